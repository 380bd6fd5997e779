"""Numbers that gearcase is held against, by subject."""
