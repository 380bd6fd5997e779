"""Verification: what a study claims of a machine, put to the test by measures that are stated beforehand."""
