"""Coordinates of the assembled machine, rows that read its parts, channels."""
