"""Linear elasticity: materials and the element matrices of tetrahedra, sections and twisted hexahedra."""
