"""Imported bodies: stiffness and mass matrices exported from other programs, read, checked and reduced further."""
