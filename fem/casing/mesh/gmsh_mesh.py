"""Meshes of a geometry through gmsh and OpenCASCADE: geometry -> CasingMesh.

Geometry is built in millimetres (the tolerances of OpenCASCADE are absolute) and returned in metres. With one thread
and a fixed seed the same input gives the same mesh. Mid-side nodes lie on the curved surfaces.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fem.casing.geometry.housing import Housing
from fem.casing.mesh.cad_file import SMALL_EDGE, named, read_step, refinements, small_edges
from fem.casing.mesh.finished_mesh import RawMesh, finished_mesh
from fem.casing.mesh.gmsh_session import numbered_nodes, session
from fem.casing.mesh.housing_solid import build_solid, find_patches
from fem.casing.mesh.imported_housing import ImportedHousing, check_extent, finish, seat_point
from fem.casing.mesh.key_points import locate
from fem.casing.mesh.mesh import CasingMesh, MeshError
from fem.casing.mesh.quality import GOOD_QUALITY, QUALITY_LIMIT, straightened
from fem.casing.mesh.sizes import MM, Refinement, Sizes, follow_fillets, set_sizes
from fem.casing.mesh.surface import Surface
from fem.processes.own_process import DAMAGED, READER, call_in_own_process

_CRASHED = "if `gearcase housing` can read it, try another element size; otherwise export it again"
_ROUND, _LONG = 25, 2  # points of the grid around a cylinder and along it
_EXACT = {"Plane", "Cylinder", "Cone", "Sphere", "Torus"}  # in a solid of these, only cylinders can be bores
_SHORT, _AT_SHORT = 0.1, 8.0  # edges below this share of the element size; elements there, in lengths of the edge
_TO_VTK = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]  # gmsh swaps the mid-side nodes 23 and 13


def mesh_housing(
    housing: Housing,
    sizes: Sizes | None = None,
    element: str = "tetrahedron-10",
    *,
    element_size: float = 0.022,
) -> CasingMesh:
    """Mesh a housing with tetrahedra.

    Parameters
    ----------
    housing : Housing
    sizes : instead of `element_size`, with finer bores and feet
    element : "tetrahedron-10" or "tetrahedron-4"
    element_size : m, target edge length; bores get at least twelve elements around

    Raises
    ------
    MeshError : element size out of range, an element below a quality limit (with its position), a missing surface
    """
    sizes = sizes or Sizes(element=element_size)
    check_element_size(housing, sizes.element)
    with session() as gmsh:
        build_solid(gmsh, housing)
        patches = find_patches(gmsh, housing)
        finer = [
            Refinement(
                surfaces=patches[bore.name],
                size=sizes.at_bore(bore.diameter),
                near=(bore.boss_diameter - bore.diameter) / 2,
                far=bore.boss_diameter,
            )
            for bore in housing.bores
        ]
        feet, ground = housing.feet, [tag for name in housing.ground_points() for tag in patches[name]]
        if sizes.foot is not None or feet.pad_diameter:
            local = sizes.at_foot(feet.bolt_diameter or feet.pad_diameter)
            far = feet.height + 2 * (sizes.element - local)
            finer.append(Refinement(ground, local, near=feet.pad_height, far=far))
        follow_fillets(gmsh, sizes.element, finer)
        raw, remedy = tetrahedra(gmsh, sizes.element, finer, patches), _remedy(gmsh, housing, sizes)
    points = housing.ground_points() | {bore.name: housing.bore_centre(bore) for bore in housing.bores}
    return finished_mesh(
        raw,
        lambda surface: ({name: np.flatnonzero(surface.groups[name]) for name in patches}, points),
        name="casing mesh",
        element=element,
        element_size=sizes.element,
        remedy=remedy,
    )


def _remedy(gmsh: Any, housing: Housing, sizes: Sizes) -> str:
    """What to do about bad elements: remove the shortest edge of the solid, or reduce the element size."""
    least = _SHORT * MM * sizes.element
    if not (short := small_edges(gmsh, least)):
        return sizes.smaller
    extent, middle, _ = short[0]
    parts = [
        name
        for name, (low, high) in (housing.foot_boxes() | housing.rib_boxes()).items()
        if (np.maximum(MM * low - middle, middle - MM * high) <= extent).all()
    ]
    x, y, z = middle
    return (
        f"The shortest edge of the housing, {extent:.2g} mm at ({x:.5g}, {y:.5g}, {z:.5g}) mm, is next to "
        f"{' and '.join(parts) or 'no foot or rib'}. Correct the dimensions there, so that the faces coincide or are "
        f"{least:.2g} mm or more from each other"
    )


def check_element_size(housing: Housing, size: float) -> None:
    """MeshError unless an element size (m) suits the walls and the box of a housing."""
    smallest, largest = housing.thinnest_wall / 10, min(housing.length, housing.width, housing.height)
    if not smallest <= size <= largest:
        raise MeshError(
            f"element size {MM * size:.4g} mm is out of range. Set {MM * smallest:.4g} mm (a tenth of the wall) to "
            f"{MM * largest:.4g} mm (the smallest side)"
        )


def mesh_step(housing: ImportedHousing, sizes: Sizes, element: str) -> CasingMesh:
    """Mesh the solid of a STEP file with tetrahedra, finer at the bearing seats.

    Raises
    ------
    MeshError : see `cad_file` and `imported`; an element below a quality limit (with its position), or a crash of the
        mesher
    """
    raw, small = call_in_own_process(READER.format(housing.file.name), MeshError, _CRASHED, _mesh_solid, housing, sizes)
    remedy = sizes.smaller
    if small:
        extent, (x, y, z), _ = small[0]
        remedy = (
            f"{len(small)} edges of the file are smaller than {SMALL_EDGE:g} mm, the smallest of {extent:.2g} mm at "
            f"({x:.5g}, {y:.5g}, {z:.5g}) mm of the file: remove such features in the CAD program"
        )
    return finish(housing, raw, element=element, element_size=sizes.element, remedy=remedy)


def _mesh_solid(housing: ImportedHousing, sizes: Sizes) -> tuple[RawMesh, list[tuple[float, np.ndarray, int]]]:
    """The tetrahedra of the solid in a STEP file, and its small edges."""
    with session() as gmsh:
        read_step(gmsh, housing)
        small = small_edges(gmsh)
        finer = refinements(gmsh, housing, sizes)
        follow_fillets(gmsh, sizes.element, finer)
        return tetrahedra(gmsh, sizes.element, finer, {}), small


def find_seats(housing: ImportedHousing) -> dict[str, np.ndarray | MeshError]:
    """Bearing point (3,), or the error, of every seat of a STEP solid that can be located without a volume mesh.

    Every cylindrical face is triangulated on a grid over its parameters; holes in it are ignored. Seats located by axis
    and diameter of a bore are found in a fraction of the meshing time.

    Raises
    ------
    MeshError : the file cannot be read, or has another unit
    """
    return call_in_own_process(READER.format(housing.file.name), MeshError, DAMAGED, _find_seats, housing)


def _find_seats(housing: ImportedHousing) -> dict[str, np.ndarray | MeshError]:
    with session() as gmsh:
        read_step(gmsh, housing)
        box = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
        check_extent(housing, box, 1 / MM)
        kinds = {tag: gmsh.model.getType(2, tag) for _, tag in gmsh.model.getEntities(2)}
        surface = _cylinders(gmsh, housing, [tag for tag, kind in kinds.items() if kind == "Cylinder"])
    found: dict[str, np.ndarray | MeshError] = {}
    for seat in housing.seats:
        try:
            facets = locate(surface, seat.name, seat.locator)
        except MeshError as error:
            if set(kinds.values()) <= _EXACT:
                found[seat.name] = error
            continue
        try:
            found[seat.name] = seat_point(surface, seat, facets)
        except MeshError as error:
            found[seat.name] = error
    return found


def _cylinders(gmsh: Any, housing: ImportedHousing, faces: list[int]) -> Surface:
    """The cylindrical faces of the solid as triangles between points of a grid."""
    points, triangles = [np.zeros((0, 3))], [np.zeros((0, 3), int)]
    for count, tag in enumerate(faces):
        low, high = gmsh.model.getParametrizationBounds(2, tag)
        around, along = np.linspace(low[0], high[0], _ROUND), np.linspace(low[1], high[1], _LONG)
        grid = np.stack(np.meshgrid(around, along, indexing="ij"), axis=-1).reshape(-1)
        points.append(np.array(gmsh.model.getValue(2, tag, grid.tolist())).reshape(-1, 3))
        first = _LONG * np.arange(_ROUND - 1)[:, None] + np.arange(_LONG - 1) + count * _ROUND * _LONG
        corner = first.ravel()
        triangles.append(np.column_stack([corner, corner + _LONG, corner + 1]))
        triangles.append(np.column_stack([corner + 1, corner + _LONG, corner + _LONG + 1]))
    return Surface(housing.placed(np.vstack(points), 1 / MM), np.vstack(triangles))


def write_step(housing: Housing, path: Path) -> None:
    """Write the solid of a parametric housing as STEP (AP214, mm); the same housing gives the same bytes."""
    with session() as gmsh:
        build_solid(gmsh, housing)
        gmsh.write(str(path))
    text = named(path.read_text(encoding="latin-1"), "housing")
    path.write_text(text, encoding="latin-1", newline="\n")


def tetrahedra(gmsh: Any, element: float, refinements: list[Refinement], patches: Mapping[str, list[int]]) -> RawMesh:
    """Mesh the current model with ten-node tetrahedra, nodes in m, and the triangles of every patch.

    Parameters
    ----------
    gmsh : an open session whose model is in mm
    element : m, edge length where nothing is refined
    refinements : regions of smaller elements
    patches : tags of the surfaces of every patch by its name

    If an element is below the quality limit, the mesh is made once more with smaller elements at short edges, as
    between a foot and a rib that almost coincide. Edges below SMALL_EDGE are refused: the elements would be too many.
    """
    _generate(gmsh, element, refinements)
    short = small_edges(gmsh, _SHORT * MM * element)
    if short and short[0][0] >= SMALL_EDGE and _worst_quality(gmsh) < QUALITY_LIMIT:
        steps = [Refinement((), _AT_SHORT * e / MM, near=0.0, far=1.5 * element, edges=[tag]) for e, _, tag in short]
        gmsh.model.mesh.clear()
        _generate(gmsh, element, [*refinements, *steps])
    gmsh.model.mesh.setOrder(2)
    _, _, connectivity = gmsh.model.mesh.getElements(3)
    points, place = numbered_nodes(gmsh)
    elements = place[connectivity[0].reshape(-1, 10)[:, _TO_VTK]]
    nodes = straightened(points / MM, elements)
    return RawMesh(
        nodes=nodes,
        elements=elements,
        facets={name: place[np.vstack([_triangles(gmsh, tag) for tag in tags])] for name, tags in patches.items()},
    )


def _generate(gmsh: Any, element: float, refinements: list[Refinement]) -> None:
    """Four-node tetrahedra, improved if one of them is not good; see `tetrahedra`."""
    set_sizes(gmsh, element, refinements)
    gmsh.model.mesh.generate(3)
    if _worst_quality(gmsh) < GOOD_QUALITY:
        gmsh.model.mesh.optimize("Netgen")


def _triangles(gmsh: Any, face: int) -> np.ndarray:
    """Tags of the corners (f, 3) of the triangles on a face."""
    _, _, connectivity = gmsh.model.mesh.getElements(2, face)
    return connectivity[0].reshape(-1, 6)[:, :3]


def _worst_quality(gmsh: Any) -> float:
    _, tags, _ = gmsh.model.mesh.getElements(3)
    return min(float(np.min(gmsh.model.mesh.getElementQualities(own, "minSICN"))) for own in tags)
