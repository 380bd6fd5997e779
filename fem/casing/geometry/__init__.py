"""Dimensions of a parametric housing, and whether they make a sound body."""
