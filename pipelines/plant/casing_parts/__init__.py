"""Parts of a casing and the joints between them, from the scene to SI."""
