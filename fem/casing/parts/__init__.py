"""Parts of a housing, the joints between them, and the forces of their weight on the feet."""
