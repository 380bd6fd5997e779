"""27-node hexahedra of a plain housing: its x-z section extruded along y in layers, wherever there is material.

A plain housing consists of boxes and of cylinders along y, so every part of it is a union of cells of the section over
an interval of y. Walls get one element through their thickness, because a quadratic element represents bending exactly.
Edge-singularity enrichment (`fem.casing.enrichment`) corrects the error at the edges of the body.
"""

from __future__ import annotations

import numpy as np

from fem.casing.geometry.dimensions import HousingError
from fem.casing.geometry.housing import Housing
from fem.casing.mesh.finished_mesh import RawMesh, finished_mesh
from fem.casing.mesh.housing_section import divided, lines_across, section, shaft_places
from fem.casing.mesh.mesh import CasingMesh, MeshError
from fem.casing.mesh.sizes import Sizes
from fem.elements.solid_elements import SOLIDS
from fem.numerics.quadratic_grids import with_middles

ELEMENT = SOLIDS["hexahedron-27"]
_NEAR = 1e-7  # m


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
        remedy=f'{sizes.smaller}, or casing.element = "tetrahedron-10"',
    )


def extruded_hexahedra(housing: Housing, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3), m, and elements (e, 27) of a plain housing.

    Parameters
    ----------
    housing : a closed box with only bosses and feet
    size : m, largest side of an element

    Raises
    ------
    HousingError : see `shaft_places`
    """
    (low, high), (inner_low, inner_high) = housing.box, housing.cavity
    places = shaft_places(housing, size)
    feet = list(housing.foot_boxes().values())
    corners = np.array([low, high, inner_low, inner_high, *[corner for foot in feet for corner in foot]])
    ends = [end for bore in housing.bores for end in housing.bore_span(bore)]
    fixed = (
        [*corners[:, 0], *lines_across(places, 0, size)],
        [*corners[:, 1], *ends],
        [*corners[:, 2], *lines_across(places, 1, size)],
    )
    x, y, z = (divided(lines, size) for lines in fixed)
    return _extruded(housing, *section(places, x, z, size=size), y)


def inside(housing: Housing, points: np.ndarray) -> np.ndarray:
    """Whether points (..., 3) are in the body of a plain housing; either result is possible on its surface."""
    body = _in_box(points, *housing.box) & ~_in_box(points, *housing.cavity)
    for corners in housing.foot_boxes().values():
        body |= _in_box(points, *corners)
    hollow = np.zeros(body.shape, bool)
    for bore in housing.bores:
        start, end = housing.bore_span(bore)
        radius = np.hypot(points[..., 0] - bore.x, points[..., 2] - bore.z)
        along = (points[..., 1] > start) & (points[..., 1] < end)
        body |= along & (radius < bore.boss_diameter / 2)
        hollow |= along & (radius < bore.diameter / 2)
    return np.asarray(body & ~hollow)


def patches(housing: Housing, nodes: np.ndarray, triangles: np.ndarray) -> dict[str, np.ndarray]:
    """Indices of the surface triangles (t, 3) on every ground face and bearing seat, by its name."""
    corners, found = nodes[triangles], {}
    for name, (low, high) in housing.foot_boxes().items():
        bottom = (abs(corners[..., 2] - low[2]) < _NEAR).all(axis=1)
        found[name] = np.flatnonzero(bottom & _in_box(corners.mean(axis=1)[:, :2], low[:2], high[:2]))
    for bore in housing.bores:
        start, end = housing.bore_span(bore)
        radius = np.hypot(corners[..., 0] - bore.x, corners[..., 2] - bore.z)
        along = (corners[..., 1] > start - _NEAR) & (corners[..., 1] < end + _NEAR)
        found[bore.name] = np.flatnonzero(((abs(radius - bore.diameter / 2) < _NEAR) & along).all(axis=1))
    return found


def _in_box(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    return np.asarray(((points > low) & (points < high)).all(axis=-1))


def _extruded(
    housing: Housing, flat: np.ndarray, cells: np.ndarray, y_lines: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Hexahedra over the cells and layers whose middle lies in the body."""
    levels = with_middles(y_lines)
    middle = flat[cells[:, 1, 1]]
    points = np.empty((len(middle), len(y_lines) - 1, 3))
    points[..., 0], points[..., 1], points[..., 2] = middle[:, None, 0], levels[1::2], middle[:, None, 1]
    cell, layer = np.nonzero(inside(housing, points))
    across, turn, up = np.round(2 * ELEMENT.library.doflocs).astype(int).T  # positions 0, 1, 2 of the local nodes
    number = cells[cell][:, across, turn] * len(levels) + 2 * layer[:, None] + (2 - up)
    used, elements = np.unique(number, return_inverse=True)
    place, level = np.divmod(used, len(levels))
    nodes = np.column_stack([flat[place, 0], levels[level], flat[place, 1]])
    return nodes, elements.reshape(number.shape)
