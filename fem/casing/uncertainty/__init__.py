"""Numerical uncertainty of casings from mesh and damping: errors of their modes, and random samples of these."""
