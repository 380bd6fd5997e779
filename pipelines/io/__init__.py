"""Where a user's texts, files and arguments come in and messages go out."""
