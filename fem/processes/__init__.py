"""Child processes: calls in separate processes, and their executor."""
