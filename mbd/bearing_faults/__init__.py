"""Rolling bearings with spalls, and cages that slip."""
