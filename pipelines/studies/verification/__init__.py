"""Verification: what a study claims of a machine, checked by measures that are stated in advance."""
