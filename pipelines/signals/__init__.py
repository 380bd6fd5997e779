"""Responses, spectra, lines of a fault and the verdict."""
