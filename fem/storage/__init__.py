"""Storage of results: records with units, HDF5 files, the cache folder, and counts of expensive computations."""
