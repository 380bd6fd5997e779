"""Run-ups: spectra over speed and order, cuts along an order, natural frequencies over speed beside them."""
