"""Tooth faults: their dimensions, checks against a gear, and effect on a mesh law. One file per kind."""
