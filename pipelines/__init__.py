"""Scenes in, results out. The names that users may rely on are in the package `gearcase`."""
