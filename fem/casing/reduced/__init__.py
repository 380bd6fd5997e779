"""Reduction of solid elements to a reduced body: condensation, modes, damping, and their accuracy."""
