"""Dense blocks, sparse factorisation and compiled functions: nothing here knows of gears or casings."""
