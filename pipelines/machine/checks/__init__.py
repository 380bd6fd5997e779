"""What can be known to be wrong, or questionable, in a scene before anything is computed."""
