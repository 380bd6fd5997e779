"""The models of the mesh stiffness, from inexpensive to expensive: one file each."""
