"""What can be known to be wrong, or doubtful, in a scene before anything is computed."""
