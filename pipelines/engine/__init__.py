"""Cached steps of any pipeline: graph, keys, storage, processes, progress. Knows nothing of gears."""
