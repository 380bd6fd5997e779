"""Casings as uncertain as their meshes and their damping leave them: errors of their modes, and draws from these."""
