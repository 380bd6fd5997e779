"""What drives and loads the machine of a scene, in SI."""
