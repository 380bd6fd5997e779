"""Checks of a casing of finite elements without meshing it: element sizes, and positions of the bearing seats."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.casing.geometry.dimensions import HousingError
from fem.casing.geometry.housing import Housing
from fem.casing.geometry.locators import ByCylinder, ByGroup, ByPlane, Locator
from fem.casing.mesh.imported_housing import ALONG_Y, OFF_AXIS, ImportedHousing
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.sizes import Sizes
from fem.casing.parts.casing_choices import FEWEST_MOUNTS, few_feet
from mbd.parts.coordinate_layout import BEARING_PLACE_TOLERANCE
from pipelines.io.errors import Problem
from pipelines.machine.machine_model import MachineModel
from pipelines.machine.scene_bearings import placed_bearings
from pipelines.scene.scene import Scene

if TYPE_CHECKING:
    from fem.casing.imported.imported_casing import ImportedMatrices

MOST_ELEMENTS = 1_500_000  # quadratic tetrahedra, 2 million nodes: their factorisation needs about 60 GB
MOST_NODES = 2_000_000
OR_BAND = ", or a lower casing.band_Hz if elements_per_wavelength is set"
LARGEST_LOOK = 10e6  # bytes; larger housing files are not read for these checks


def bad_casing(scene: Scene, machine: MachineModel) -> Iterator[Problem]:
    """All problems of a casing that can be found without its mesh."""
    made: Any = machine.structure.housing
    table, given = scene.casing, scene.housing.model
    if getattr(table, "ground", "") == "springs":
        yield from _bad_mounts(scene, made)
    if given == "matrices":
        yield from _bad_matrices(scene, made)
    elif given != "parametric":
        yield from list(_misplaced_seats(scene, made)) or _seats_in_file(scene, made)
    if given != "parametric":
        return
    yield from _off_middle(scene, {bore.name: made.bore_centre(bore) for bore in made.bores}, "boss")
    casing: Any = machine.casing
    if not casing.needs_mesh(machine.structure):
        return
    from fem.casing.mesh.gmsh_mesh import check_element_size

    sizes = casing.sizes(machine.structure)
    try:
        check_element_size(made, sizes.element)
    except MeshError as error:
        yield Problem("casing.element_size_mm", str(error), "", f"{table.element_size_mm:g}")
        return
    if table.element.startswith("hexahedron"):
        yield from _no_hexahedra(made, sizes, table.element, table.element_size_mm)
    elif (count := _elements(made, sizes.element)) > MOST_ELEMENTS:
        least = sizes.element * (count / MOST_ELEMENTS) ** (1 / 3)
        yield Problem(
            "casing.element_size_mm",
            f"elements of {1000 * sizes.element:.3g} mm give about {count / 1e6:.1f} million tetrahedra, more than "
            f"{MOST_ELEMENTS / 1e6:.1f} million",
            f"Set {1000 * least:.2g} or more{OR_BAND}",
            f"{table.element_size_mm:g}",
        )


def _bad_matrices(scene: Scene, made: Any) -> Iterator[Problem]:
    """Matrices that cannot be used, wrong nodes of bearings and feet, and sensors far from all nodes."""
    places = _places_of_matrices(made)
    if isinstance(places, HousingError):
        yield Problem("casing.housing.file", str(places), "", f'"{scene.housing.file}"')
        return
    from fem.casing.reduced.attachment import AttachmentError, nearest_surface_point

    for number, sensor in enumerate(made.sensors if len(places) else (), 1):
        try:
            nearest_surface_point(places, np.zeros((0, 3), int), np.array(sensor.position))
        except AttachmentError as error:
            yield Problem(f"sensors.{number}.position_mm", str(error))


@functools.lru_cache(maxsize=8)
def _places_of_matrices(made: ImportedMatrices) -> np.ndarray | HousingError:
    """Places (k, 3) in m of the nodes of imported matrices; empty if the files cannot be read quickly."""
    from fem.casing.imported.imported_body import MatrixError
    from fem.casing.imported.imported_casing import checked_body

    if Path(made.files.stiffness).stat().st_size > LARGEST_LOOK:
        return np.zeros((0, 3))
    try:
        return checked_body(made)[0].places
    except MatrixError as error:
        return error


def _bad_mounts(scene: Scene, made: Any) -> Iterator[Problem]:
    """Too few feet on springs, and rows of mounts that do not fit the feet; a plane has feet that only a mesh shows."""
    feet = made.grounds if scene.parametric is None else made.ground_points()
    count, rows = len(feet), scene.casing.mounts_N_per_um
    if any(isinstance(foot, ByPlane) for foot in feet):
        return
    if count < FEWEST_MOUNTS:
        yield Problem("casing.ground", few_feet(count), "", '"springs"')
    elif len(rows) not in (1, count):
        yield Problem(
            "casing.mounts_N_per_um",
            f"has {len(rows)} rows, and the casing has {count} feet",
            f"Set one row of x, y, z for all feet, or {count} rows",
        )


def _no_hexahedra(made: Housing, sizes: Sizes, element: str, size: float) -> Iterator[Problem]:
    """Reasons why a housing cannot be meshed with hexahedra."""
    from fem.casing.mesh.housing_section import shaft_places

    count = _nodes(made, sizes.element)
    if count > MOST_NODES:
        yield Problem(
            "casing.element_size_mm",
            f"hexahedra of {1000 * sizes.element:.3g} mm give {count / 1e6:.1f} million nodes or more, more than "
            f"{MOST_NODES / 1e6:.1f} million",
            f"Set {1000 * sizes.element * (count / MOST_NODES) ** (1 / 2):.2g} or more{OR_BAND}",
            f"{size:g}",
        )
        return
    try:
        shaft_places(made, sizes.element)
    except HousingError as error:
        yield Problem("casing.element", str(error), "", element)


def _walls(made: Housing) -> list[tuple[float, float]]:
    """Area (m2) and thickness (m) of the walls of a housing, both of each kind together."""
    length, width, height = made.length, made.width, made.height
    return [
        (2 * length * width, max(made.wall("floor"), made.wall("cover"))),
        (2 * length * height, made.wall("side")),
        (2 * width * height, made.wall("end")),
    ]


def _elements(made: Housing, size: float) -> float:
    """Approximate number of tetrahedra of an edge length (m) in the walls of a housing."""
    return sum(area * thickness for area, thickness in _walls(made)) / (size**3 / (6 * math.sqrt(2)))


def _nodes(made: Housing, size: float) -> float:
    """Number of nodes of hexahedra of an edge length (m) in the walls of a housing, without bosses.

    There are one or more elements through the thickness.
    """
    return sum(4 * area / size**2 * (2 * math.ceil(thickness / size) + 1) for area, thickness in _walls(made))


def _off_middle(scene: Scene, points: dict[str, np.ndarray], what: str) -> Iterator[Problem]:
    """Bearings that are not in the middle of their seat, where their load acts on the casing."""
    keys = " by casing.housing.width_mm or boss_length_mm" if what == "boss" else ""
    for one in placed_bearings(scene):
        middle, y = 1000 * float(points[one.name][1]) if one.name in points else math.nan, 1000 * one.y
        if abs(middle - y) > 1000 * BEARING_PLACE_TOLERANCE:
            yield Problem(
                f"shafts.{one.shaft + 1}.bearing_positions_mm",
                f"{one.name} at y = {y:g} mm is {abs(middle - y):.3g} mm away from the middle of its {what} at "
                f"{middle:.6g} mm, where the casing takes its load (limit {1000 * BEARING_PLACE_TOLERANCE:g} mm)",
                f"Set its value number {one.place + 1} to {middle:.6g}, or move the {what}{keys}",
            )


def _misplaced_seats(scene: Scene, made: ImportedHousing) -> Iterator[Problem]:
    """Seats whose axis, as given in the scene, is not that of their shaft, and direction vectors of length 0."""
    paths = {seat.name: f"casing.housing.bearings.{number}" for number, seat in enumerate(scene.housing.bearings, 1)}
    shafts = {one.name: one.shaft + 1 for one in placed_bearings(scene)}
    for seat in made.seats:
        path = paths[seat.name]
        yield from _group_of_step(made, path, seat.locator, "through_mm and diameter_mm", f"{seat.name}: ")
        if not isinstance(seat.locator, ByCylinder) or seat.shaft_point is None:
            continue
        axis, through = np.array(seat.locator.axis), np.array(seat.locator.through)
        size = float(np.linalg.norm(axis))
        if not size or not abs(axis[1]) / size >= ALONG_Y:
            yield Problem(
                f"{path}.axis",
                f"the seat of {seat.name} must run along y, as shaft {shafts[seat.name]} does",
                "Delete axis, or turn the file by casing.housing.axes",
                f"{list(seat.locator.axis)}",
            )
            continue
        target = np.array(seat.shaft_point)
        place = through + axis * (target[1] - through[1]) / axis[1]
        off = float(np.hypot(*(place - target)[[0, 2]]))
        if off > OFF_AXIS:
            yield Problem(
                f"{path}.through_mm",
                f"the axis of the seat of {seat.name} is {1000 * off:.4g} mm away from that of shaft "
                f"{shafts[seat.name]} at x {1000 * target[0]:.6g}, z {1000 * target[2]:.6g} mm (limit "
                f"{1000 * OFF_AXIS:g} mm)",
                "Correct it, casing.housing.origin_mm, or the place of the shaft (centre_distance_mm, direction_deg)",
                str([round(1000 * value, 6) for value in seat.locator.through]),
            )
    for number, ground in enumerate(made.grounds, 1):
        path = f"casing.housing.grounds.{number}"
        if isinstance(ground, ByPlane) and not any(ground.normal):
            yield Problem(f"{path}.normal", "is no direction", "Set one, as in [0.0, 0.0, 1.0]")
        yield from _group_of_step(made, path, ground, "point_mm, box_mm, or through_mm and normal")


def _group_of_step(made: ImportedHousing, path: str, locator: Locator, instead: str, of: str = "") -> Iterator[Problem]:
    """Problem of a place that is given by a group, in a file without groups.

    Parameters
    ----------
    made, path, locator : the housing, path of the place in the scene, and the place
    instead : keys that locate the place without a group
    of : what is located, for the message
    """
    if isinstance(locator, ByGroup) and made.is_step:
        yield Problem(f"{path}.group", f"{of}a STEP file has no groups", f"Set {instead} instead", f'"{locator.group}"')


def _seats_in_file(scene: Scene, made: ImportedHousing) -> Iterator[Problem]:
    """Seats that are not in the file, or not where the bearings are."""
    table, found = scene.housing, _looked_up(made, scene.casing.element)
    if isinstance(found, MeshError):
        yield Problem("casing.housing.file", str(found), "", f'"{table.file}"')
        return
    for number, seat in enumerate(table.bearings, 1):
        if isinstance(point := found.get(seat.name), MeshError):
            yield Problem(f"casing.housing.bearings.{number}", str(point))
    points = {name: point for name, point in found.items() if not isinstance(point, MeshError)}
    yield from _off_middle(scene, points, "seat")


@functools.lru_cache(maxsize=8)
def _looked_up(made: ImportedHousing, element: str) -> dict[str, np.ndarray | MeshError] | MeshError:
    """Problems of bearing points by name; empty if the file cannot be read quickly."""
    if made.file.stat().st_size > LARGEST_LOOK:
        return {}
    try:
        if made.is_step:
            from fem.casing.mesh.gmsh_mesh import find_seats

            return find_seats(made)
        from fem.casing.mesh.imported_housing import mesh_from_file

        mesh = mesh_from_file(made, element)
        return dict(zip(mesh.patch_names, mesh.patch_points, strict=True))
    except MeshError as error:
        return error
    except ImportError:
        return {}  # without gmsh or meshio a stored mesh may still serve
