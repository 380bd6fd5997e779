"""Other programs on the same problems, side by side with gearcase; each is skipped with a message when absent."""
