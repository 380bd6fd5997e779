"""What a housing is put together of: its parts, the joints between them, and what their weight asks of the feet."""
