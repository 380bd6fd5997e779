"""What is kept of finite-element work: records with units, HDF5 files, counts of what was built."""
