"""Mesh of a casing from a geometry of any source."""

from __future__ import annotations

from fem.casing.geometry.dimensions import HousingError
from fem.casing.geometry.housing import Housing
from fem.casing.mesh.extruded import extruded_hexahedra, patches
from fem.casing.mesh.finished import RawMesh, finished_mesh
from fem.casing.mesh.imported import ImportedHousing, mesh_from_file
from fem.casing.mesh.mesh import CasingMesh, MeshError
from fem.casing.mesh.sizes import MM, Sizes
from fem.elements.solid_elements import SOLIDS

Geometry = Housing | ImportedHousing


def mesh_geometry(geometry: Geometry, sizes: Sizes, element: str = "tetrahedron-10") -> CasingMesh:
    """Mesh of one kind of element with patches ground_1, ... and bearing_1, ...; a mesh file keeps its sizes.

    Raises
    ------
    MeshError : see `mesher.mesh_housing`, `mesher.mesh_step`, `imported.mesh_from_file` and `mesh_extruded`
    """
    if isinstance(geometry, ImportedHousing) and not geometry.is_step:
        return mesh_from_file(geometry, element)
    if isinstance(geometry, Housing) and SOLIDS[element].corners == 8:
        return mesh_extruded(geometry, sizes, element)
    from fem.casing.mesh import mesher

    if isinstance(geometry, ImportedHousing):
        return mesher.mesh_step(geometry, sizes, element)
    return mesher.mesh_housing(geometry, sizes=sizes, element=element)


def mesh_extruded(housing: Housing, sizes: Sizes, element: str = "hexahedron-20") -> CasingMesh:
    """Hexahedra of a plain housing, one through the thickness of every wall.

    Raises
    ------
    MeshError : a housing that is not plain, bosses without enough space around them, an element below a quality limit
    """
    try:
        nodes, elements = extruded_hexahedra(housing, sizes.element)
    except HousingError as error:
        raise MeshError(str(error)) from error
    points = housing.ground_points() | {bore.name: housing.bore_centre(bore) for bore in housing.bores}
    return finished_mesh(
        RawMesh(nodes=nodes, elements=elements),
        lambda surface: (patches(housing, surface.points, surface.triangles), points),
        name="casing mesh",
        element=element,
        element_size=sizes.element,
        remedy=f"Use an element size below {MM * sizes.element:.4g} mm, or element tetrahedron-10",
    )
