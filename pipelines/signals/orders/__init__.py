"""Orders: rotation angle of a recording, spectra over speed and order, and natural frequencies over speed."""
