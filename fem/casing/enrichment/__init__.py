"""Functions that hexahedra are given at the edges where stresses grow without bound."""
