"""Hexahedra of plain parametric housings."""
