"""Geometry of a casing, whatever it comes from, and its mesh."""

from __future__ import annotations

from fem.casing.geometry.housing import Housing
from fem.casing.meshing.imported import ImportedHousing, mesh_from_file
from fem.casing.meshing.mesh import CasingMesh
from fem.casing.meshing.sizes import Sizes

Geometry = Housing | ImportedHousing


def mesh_geometry(geometry: Geometry, sizes: Sizes, element: str = "tetrahedron-10") -> CasingMesh:
    """Elements of one kind with the patches ground_1, ... and bearing_1, ...; a mesh file keeps its own sizes.

    Raises
    ------
    MeshError : see `mesher.mesh_housing`, `mesher.mesh_step` and `imported.mesh_from_file`
    """
    if isinstance(geometry, ImportedHousing) and not geometry.is_step:
        return mesh_from_file(geometry, element)
    from fem.casing.meshing import mesher

    if isinstance(geometry, ImportedHousing):
        return mesher.mesh_step(geometry, sizes, element)
    return mesher.mesh_housing(geometry, sizes=sizes, element=element)
