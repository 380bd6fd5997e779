"""Errors that the elements of a casing's mesh leave in its natural frequencies, measured on its meshes."""
