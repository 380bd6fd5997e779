"""Edge-singularity enrichment: functions added to hexahedra at edges where the exact stresses are singular.

`topology` numbers faces and sides. `singular_edges` finds where functions are added. `edge_section` solves the plane
problem over the section across an edge, on the grid of `graded_functions`. `profiles` collects its functions for every
node. `edge_unknowns` adds them to the elements, integrated by `integrals`. `added` joins all added unknowns.
"""
