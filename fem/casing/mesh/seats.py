"""Bearing points of an imported housing from the cylinders of a STEP solid, without a volume mesh.

Every cylindrical face is triangulated on a grid over its parameters; holes in it are ignored. Seats located by axis and
diameter of a bore are found in a fraction of the meshing time.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fem.casing.geometry.locators import ByCylinder
from fem.casing.mesh.imported import ImportedHousing, check_extent, seat_point
from fem.casing.mesh.locate import locate
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.sizes import MM
from fem.casing.mesh.step_file import read_step
from fem.casing.mesh.surface import Surface

_ROUND, _LONG = 25, 2  # points of the grid around a cylinder and along it
_EXACT = {"Plane", "Cylinder", "Cone", "Sphere", "Torus"}  # in a solid of these, only cylinders can be bores


def seat_points(gmsh: Any, housing: ImportedHousing) -> dict[str, np.ndarray | MeshError]:
    """Bearing point (3,), or the error, of every seat that can be located this way; in an open gmsh session.

    Raises
    ------
    MeshError : the file cannot be read, or has another unit
    """
    read_step(gmsh, housing)
    box = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
    check_extent(housing, box, 1 / MM)
    kinds = {tag: gmsh.model.getType(2, tag) for _, tag in gmsh.model.getEntities(2)}
    surface = _cylinders(gmsh, housing, [tag for tag, kind in kinds.items() if kind == "Cylinder"])
    found: dict[str, np.ndarray | MeshError] = {}
    for seat in housing.seats:
        if not isinstance(seat.locator, ByCylinder):
            found[seat.name] = MeshError(f"{seat.name}: a STEP file has no groups; locate it by through and diameter")
            continue
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
