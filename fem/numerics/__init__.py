"""Dense blocks, sparse factorisation, interpolation and compiled functions: nothing here knows of gears or casings."""
