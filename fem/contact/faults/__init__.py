"""Faults of teeth: what each one is, whether it fits on a gear, and what it does to a mesh law. One file per kind."""
