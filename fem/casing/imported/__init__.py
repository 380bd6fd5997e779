"""Bodies that another program assembled or reduced: stiffness and mass matrices, read, checked and reduced further."""
