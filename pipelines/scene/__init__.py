"""What the user writes: files, merging, validation, presets; the tables in engineers' units."""
