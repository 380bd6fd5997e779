"""Imported housing: a STEP solid or a mesh file, with its key points located on its surface.

The file is placed in the frame of the scene (x across the shafts, y along them, z up) by an origin and three axes:

    x = origin + unit * (x_file, y_file, z_file) @ axes

All else is in the frame of the scene, including the points that locate bearings and ground faces.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fem.casing.geometry.dimensions import GLOBAL_AXES, HousingError, Sensor
from fem.casing.geometry.locators import ByCylinder, ByPlane, Locator, Point
from fem.casing.mesh.finished_mesh import RawMesh, finished_mesh
from fem.casing.mesh.key_points import axis_place, centroid, locate, plane_parts
from fem.casing.mesh.mesh import CasingMesh, MeshError
from fem.casing.mesh.mesh_file import SUFFIXES, read_mesh_file
from fem.casing.mesh.quality import straightened
from fem.casing.mesh.surface import Surface
from fem.elements.solid_elements import CHOICES, SOLIDS, solid_element
from fem.numerics.fitted_circle import fitted_circle
from fem.numerics.message_places import in_mm

UNITS = {"m": 1.0, "cm": 1 / 100, "mm": 1 / 1000, "um": 1 / 1_000_000, "inch": 127 / 5000}  # m
STL_SUFFIXES = (".stl",)
CAD_FORMATS = {".step": "step", ".stp": "step", ".brep": "brep", ".brp": "brep", ".iges": "iges", ".igs": "iges"}
CAD_SUFFIXES = (*CAD_FORMATS, *STL_SUFFIXES)  # files that are meshed here
OFF_AXIS = 0.0005  # m: largest distance between the axis of a bore and that of its shaft
ALONG_Y = 0.9999  # least cosine between the axis of a bore and that of its shaft


@dataclass(frozen=True, kw_only=True)
class Seat:
    """A bearing seat: its locator on the surface, and the point (m) on the axis of its shaft where it must be."""

    name: str
    locator: Locator
    shaft_point: Point | None = None


@dataclass(frozen=True, kw_only=True)
class ImportedHousing:
    """A housing from a file. `sha256` is the hash of its content when the scene was read; a changed file is refused."""

    path: str
    sha256: str
    unit: str  # of the file: "m", "cm", "mm", "um", "inch"
    seats: tuple[Seat, ...]
    grounds: tuple[Locator, ...]  # ground_1, ground_2, ... in this order; a plane gives one for each of its parts
    upgrade: bool = False  # converts linear elements to quadratic ones
    solids: tuple[int, ...] = ()  # numbers (from 1) of the solids of the housing; all by default
    glue: bool = False  # bonds several solids where they touch
    origin: Point = (0.0, 0.0, 0.0)  # position of the origin of the file, m
    axes: tuple[Point, Point, Point] = GLOBAL_AXES  # directions of the file's x, y and z
    sensors: tuple[Sensor, ...] = ()

    def __post_init__(self) -> None:
        if problems := [words for wrong, words in self._problems() if wrong]:
            raise HousingError(f"housing from {Path(self.path).name}: " + "; ".join(problems))

    def _problems(self) -> Iterator[tuple[bool, str]]:
        yield (
            Path(self.path).suffix.lower() not in (*CAD_SUFFIXES, *SUFFIXES),
            f"the file is none of {', '.join((*CAD_SUFFIXES, *SUFFIXES))}",
        )
        axes = np.array(self.axes, float)
        yield (
            not np.allclose(axes @ axes.T, np.eye(3), atol=1e-6) or np.linalg.det(axes) < 0.0,
            f"its axes {self.axes} are not three orthogonal, right-handed unit vectors (limit 1e-6)",
        )
        names = [seat.name for seat in self.seats] + [sensor.name for sensor in self.sensors]
        for name in dict.fromkeys(names):
            yield names.count(name) > 1, f"the name {name!r} is given {names.count(name)} times"

    @property
    def is_step(self) -> bool:
        """Whether the file holds a solid rather than a mesh."""
        return Path(self.path).suffix.lower() in CAD_SUFFIXES

    @property
    def file(self) -> Path:
        """The file, its content checked against `sha256`. MeshError if it is missing or changed."""
        path = Path(self.path)
        if not path.is_file():
            raise MeshError(f"{self.path}: no such file")
        if content_hash(path) != self.sha256:
            raise MeshError(f"{self.path} was changed while the scene was being built; run again")
        return path

    def placed(self, points: np.ndarray, scale: float) -> np.ndarray:
        """Points of the file, in units of `scale` metres, in the frame of the scene (n, 3), m."""
        return np.array(self.origin) + scale * (points @ np.array(self.axes))


def content_hash(path: Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def mesh_from_file(housing: ImportedHousing, element: str) -> CasingMesh:
    """The mesh of a mesh file in the requested element, with its quality and key points checked.

    Raises
    ------
    MeshError : unreadable, elements of another shape, linear elements without `upgrade`, inverted or bad elements,
        unconnected parts, a size that does not fit the shafts (wrong unit), a key point that is not found
    """
    path = housing.file
    raw = read_mesh_file(path, 1000 * UNITS[housing.unit])
    given, wanted = solid_element(raw.elements), SOLIDS[element]
    words = raw.divided or f"{len(raw.elements)} {'tetrahedra' if given.corners == 4 else 'hexahedra'}"
    if given.corners != wanted.corners:
        fitting = [name for name in CHOICES if SOLIDS[name].corners == given.corners]
        cut = " are divided into tetrahedra and" if raw.divided else ""
        raise MeshError(
            f"{path.name} has {words}, which{cut} cannot become {element} elements. Set casing.element to "
            f"{' or '.join(map(repr, fitting))}"
        )
    check_extent(housing, raw.nodes, UNITS[housing.unit])
    if given.degree == 1 < wanted.degree and not housing.upgrade:
        raise MeshError(
            f"{path.name} has linear elements ({words}), far too stiff in bending. Set upgrade = true "
            f"for mid-side nodes on straight edges, or export {element} elements, which follow the bores"
        )
    mended, count = _unfolded(raw)
    mesh = finish(housing, mended, element=element, element_size=None, remedy=f"Repair the mesh {path.name}")
    return replace(mesh, straightened=count, divided=raw.divided)


def _unfolded(raw: RawMesh) -> tuple[RawMesh, int]:
    """Straighten ten-node tetrahedra that their curvature folds, as for generated meshes; returns their number too."""
    if solid_element(raw.elements).name != "tetrahedron-10":
        return raw, 0
    nodes = straightened(raw.nodes, raw.elements)
    moved = (nodes != raw.nodes).any(axis=1)
    return replace(raw, nodes=nodes), int(moved[raw.elements].any(axis=1).sum())


def finish(
    housing: ImportedHousing, raw: RawMesh, *, element: str, element_size: float | None, remedy: str
) -> CasingMesh:
    """Check a mesh and find its surface and key points.

    Parameters
    ----------
    housing : gives the position of the mesh in the frame of the scene, and the locators of its key points
    raw : nodes in units of the file, or in m if `element_size` is given
    element : one of `fem.elements.solid_elements.SOLIDS`, of the same shape
    element_size : m, with which a solid was meshed; None for a mesh from a file
    remedy : what to do about a bad element

    Raises
    ------
    MeshError : as `finished_mesh`, or a key point that is not found
    """
    name, made_here = Path(housing.path).name, element_size is not None
    return finished_mesh(
        replace(raw, nodes=housing.placed(raw.nodes, 1.0 if made_here else UNITS[housing.unit])),
        lambda surface: find_key_points(housing, surface),
        name=name,
        element=element,
        element_size=element_size,
        remedy=remedy,
    )


def find_key_points(housing: ImportedHousing, surface: Surface) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Facets (indices) and reference point (3,) of every ground face and bearing seat."""
    patches: dict[str, np.ndarray] = {}
    points: dict[str, np.ndarray] = {}
    for locator in housing.grounds:
        name = f"ground_{len(patches) + 1}"
        if isinstance(locator, ByPlane):
            parts = plane_parts(surface, name, locator)
        else:
            parts = [locate(surface, name, locator)]
        for part in parts:
            name = f"ground_{len(patches) + 1}"
            patches[name], points[name] = part, centroid(surface, part)
    for seat in housing.seats:
        facets = locate(surface, seat.name, seat.locator)
        patches[seat.name], points[seat.name] = facets, seat_point(surface, seat, facets)
    return patches, points


def check_extent(housing: ImportedHousing, points: np.ndarray, scale: float) -> None:
    """MeshError if the bearings of the shafts cannot be in the body of the file; gives the unit that would fit."""
    wanted = np.array([seat.shaft_point for seat in housing.seats if seat.shaft_point is not None])
    if not len(wanted):
        return

    def holds(factor: float) -> bool:
        low, high = housing.placed(points, factor).min(axis=0), housing.placed(points, factor).max(axis=0)
        margin, size = 0.1 * (high - low), float(np.linalg.norm(high - low))
        reach = float(np.linalg.norm(np.ptp(wanted, axis=0)))
        inside = (wanted > low - margin).all() and (wanted < high + margin).all()
        return bool(inside and size < 20 * max(reach, 1e-9)) if len(wanted) > 1 else bool(inside)

    if holds(scale):
        return
    placed = housing.placed(points, scale)
    size = " x ".join(f"{1000 * value:.4g}" for value in np.ptp(placed, axis=0))
    span = " x ".join(f"{1000 * value:.4g}" for value in np.ptp(wanted, axis=0))
    fits = [unit for unit, factor in UNITS.items() if factor != scale and holds(factor)]
    remedy = f'The file seems to be in {fits[0]}: set unit = "{fits[0]}"' if fits else "Check unit, origin and axes"
    raise MeshError(
        f"{Path(housing.path).name} read in {housing.unit} spans {size} mm from {in_mm(placed.min(axis=0))}, but "
        f"the bearings of the shafts span {span} mm from {in_mm(wanted.min(axis=0))}. {remedy}"
    )


def seat_point(surface: Surface, seat: Seat, facets: np.ndarray) -> np.ndarray:
    """The bearing point on the axis in the middle of the seat; MeshError if it is not on the shaft."""
    if isinstance(seat.locator, ByCylinder):
        through, axis = np.array(seat.locator.through), np.array(seat.locator.axis)
        point, allowed = axis_place(surface, facets, through, axis), OFF_AXIS
    else:
        corners, axis = surface.corners[facets].reshape(-1, 3), np.array([0.0, 1.0, 0.0])
        fitted = fitted_circle(corners[:, [0, 2]])
        middle, allowed = centroid(surface, facets), OFF_AXIS
        if fitted is not None:
            middle[[0, 2]] = fitted[0]
        else:  # grooves, or a group larger than the seat: its centroid is not on the axis
            allowed = 0.3 * float(np.linalg.norm((corners - middle)[:, [0, 2]], axis=1).mean())
        point = axis_place(surface, facets, middle, axis)
    if seat.shaft_point is None:
        return point
    wanted = np.array(seat.shaft_point)
    off = float(np.hypot(*(point - wanted)[[0, 2]]))
    tilt = abs(axis[1]) / np.linalg.norm(axis)
    if off > allowed or tilt < ALONG_Y:
        raise MeshError(
            f"{seat.name}: its seat has its middle at {in_mm(point)} and its axis along {tuple(axis.tolist())}, "
            f"{1000 * off:.4g} mm from the axis of its shaft at x {1000 * wanted[0]:.5g}, z {1000 * wanted[2]:.5g} mm "
            f"(limit {1000 * allowed:.3g} mm, along y). Correct through_mm of the seat, or origin_mm, axes or unit of "
            "the file"
        )
    along = surface.corners[facets][..., 1]
    if not along.min() <= wanted[1] <= along.max():
        raise MeshError(
            f"{seat.name}: the bearing at y = {1000 * wanted[1]:.5g} mm is outside its seat "
            f"({1000 * along.min():.5g} to {1000 * along.max():.5g} mm). Set bearing_positions_mm of its shaft, "
            "or correct through_mm of the seat"
        )
    return np.array([wanted[0], point[1], wanted[2]])
