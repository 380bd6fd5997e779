"""The mesher for a geometry of a casing: parametric, CAD file or mesh file, with tetrahedra or hexahedra."""

from __future__ import annotations

from fem.casing.geometry.housing import Housing
from fem.casing.mesh.extruded import mesh_extruded
from fem.casing.mesh.imported_housing import ImportedHousing, mesh_from_file
from fem.casing.mesh.mesh import CasingMesh, MeshError
from fem.casing.mesh.sizes import Sizes
from fem.elements.solid_elements import SOLIDS
from fem.processes.own_process import call_in_own_process

Geometry = Housing | ImportedHousing
FLAT = 8.0  # elements longer than so many thicknesses of the wall may crash gmsh
_CRASHED = "set another casing.element_size_mm (with --set it overrides a --preset), or make the walls thicker"


def mesh_geometry(geometry: Geometry, sizes: Sizes, element: str = "tetrahedron-10") -> CasingMesh:
    """Mesh of one kind of element with patches ground_1, ... and bearing_1, ...; a mesh file keeps its sizes.

    Raises
    ------
    MeshError : see `mesh_housing` and `mesh_step` of `gmsh_mesh`, `mesh_from_file` and `mesh_extruded`
    """
    if isinstance(geometry, ImportedHousing) and not geometry.is_step:
        return mesh_from_file(geometry, element)
    if isinstance(geometry, Housing) and SOLIDS[element].corners == 8:
        return mesh_extruded(geometry, sizes, element)
    from fem.casing.mesh import gmsh_mesh

    if isinstance(geometry, ImportedHousing):
        return gmsh_mesh.mesh_step(geometry, sizes, element)
    if sizes.element > FLAT * geometry.thinnest_wall:
        return call_in_own_process("the mesher", MeshError, _CRASHED, gmsh_mesh.mesh_housing, geometry, sizes, element)
    return gmsh_mesh.mesh_housing(geometry, sizes, element)
