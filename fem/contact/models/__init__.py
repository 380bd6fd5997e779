"""The models of the mesh stiffness, cheap to expensive: one file each."""
