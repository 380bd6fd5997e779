"""The parts of a machine in SI, before any matrix is formed."""
