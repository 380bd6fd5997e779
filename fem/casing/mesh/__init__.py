"""Meshes of housings from any source: solid elements with named patches of the surface."""
