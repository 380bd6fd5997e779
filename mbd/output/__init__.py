"""What a run records and returns."""
