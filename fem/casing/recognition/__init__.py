"""Geometry recognition of an imported housing: solids, bores, flat faces, bolt patterns, and positions of shafts."""
