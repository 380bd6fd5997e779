"""Imported housing: a STEP solid or an existing mesh, with its key points located on its surface.

The file is placed in the frame of the scene (x across the shafts, y along them, z up) by an origin and three axes:

    x = origin + unit * (x_file, y_file, z_file) @ axes

Everything else, the points that locate bearings and ground faces included, is in the frame of the scene.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from fem.casing.geometry.dimensions import GLOBAL_AXES, HousingError, Sensor
from fem.casing.meshing.locate import (
    ByCylinder,
    ByPlane,
    Locator,
    Point,
    axis_place,
    centroid,
    locate,
    plane_parts,
)
from fem.casing.meshing.mesh import CasingMesh, MeshError
from fem.casing.meshing.mesh_file import SUFFIXES, read_mesh_file, upgraded
from fem.casing.meshing.nearest_candidates import fitted_circle
from fem.casing.meshing.quality import checked_quality
from fem.casing.meshing.sizes import mean_edge
from fem.casing.meshing.surface import Surface
from fem.elements.tetrahedra import curved
from fem.storage.ledger import count

UNITS = {"m": 1.0, "cm": 1 / 100, "mm": 1 / 1000, "um": 1 / 1_000_000, "inch": 127 / 5000}  # m
STEP_SUFFIXES = (".step", ".stp")
OFF_AXIS = 0.0005  # m: how far the axis of a bore may lie off the axis of its shaft
ALONG_Y = 0.9999  # least cosine between the axis of a bore and that of its shaft
_FACES = np.array([(0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (0, 3, 2, 7, 9, 6)])  # outwards


@dataclass(frozen=True, kw_only=True)
class Seat:
    """A bearing: where it is found on the surface, and the point on the axis of its shaft where it must lie (m)."""

    name: str
    locator: Locator
    shaft_point: Point | None = None


@dataclass(frozen=True, kw_only=True)
class ImportedHousing:
    """A housing from a file. `sha256` is that of the content when the scene was read; a changed file is refused."""

    path: str
    sha256: str
    unit: str  # of the file: "m", "cm", "mm", "um", "inch"
    seats: tuple[Seat, ...]
    grounds: tuple[Locator, ...]  # ground_1, ground_2, ... in this order; a plane gives one for each of its parts
    upgrade: bool = False  # linear tetrahedra to quadratic ones
    origin: Point = (0.0, 0.0, 0.0)  # where the origin of the file lies, m
    axes: tuple[Point, Point, Point] = GLOBAL_AXES  # directions of the file's x, y and z
    sensors: tuple[Sensor, ...] = ()

    def __post_init__(self) -> None:
        if problems := list(self._problems()):
            raise HousingError(f"housing from {Path(self.path).name}: " + "; ".join(problems))

    def _problems(self) -> Iterator[str]:
        if self.unit not in UNITS:
            yield f"unit {self.unit!r} is not one of {', '.join(UNITS)}"
        if Path(self.path).suffix.lower() not in (*STEP_SUFFIXES, *SUFFIXES):
            yield f"the file is none of {', '.join((*STEP_SUFFIXES, *SUFFIXES))}"
        axes = np.array(self.axes, float)
        if not np.allclose(axes @ axes.T, np.eye(3), atol=1e-6) or np.linalg.det(axes) < 0.0:
            yield f"its axes {self.axes} are not three orthogonal, right-handed unit vectors (limit 1e-6)"
        names = [seat.name for seat in self.seats] + [sensor.name for sensor in self.sensors]
        for name in dict.fromkeys(names):
            if names.count(name) > 1:
                yield f"the name {name!r} is given {names.count(name)} times"
        if not self.grounds:
            yield "no ground face; name at least one foot"

    @property
    def is_step(self) -> bool:
        """Whether the file holds a solid rather than a mesh."""
        return Path(self.path).suffix.lower() in STEP_SUFFIXES

    @property
    def file(self) -> Path:
        """The file, its content checked against `sha256`. MeshError if it is gone or another."""
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


def mesh_from_file(housing: ImportedHousing) -> CasingMesh:
    """The mesh of an imported mesh file, its quality and its key points checked.

    Raises
    ------
    MeshError : unreadable, linear elements without `upgrade`, inverted or bad elements, unconnected parts, a size that
        does not fit the shafts (wrong unit), a key point that is not found
    """
    path = housing.file
    read = read_mesh_file(path)
    nodes, elements = read.nodes, read.elements
    check_extent(housing, nodes, UNITS[housing.unit])
    if elements.shape[1] == 4:
        if not housing.upgrade:
            raise MeshError(
                f"{path.name} has linear tetrahedra ({len(elements)}): far too stiff in bending. Set upgrade = true "
                "for mid-side nodes on straight edges, or export ten-node tetrahedra, which follow the bores"
            )
        nodes, elements = upgraded(nodes, elements)
    groups = {name: ("triangles", items) for name, items in read.triangles.items()}
    groups |= {name: ("nodes", items) for name, items in read.node_sets.items()}
    return finish(housing, housing.placed(nodes, UNITS[housing.unit]), elements, groups, element_size=None)


def finish(
    housing: ImportedHousing,
    nodes: np.ndarray,
    elements: np.ndarray,
    groups: Mapping[str, tuple[str, np.ndarray]],
    *,
    element_size: float | None,
) -> CasingMesh:
    """Check a mesh (nodes in the frame of the scene, m), find its surface and its key points."""
    name = Path(housing.path).name
    used, flat = np.unique(elements, return_inverse=True)
    number = np.full(len(nodes), -1, np.int64)
    number[used] = np.arange(len(used))
    nodes, elements = nodes[used], flat.reshape(elements.shape)
    remedy = f"Use an element size below {1000 * element_size:.4g} mm" if element_size else f"Repair the mesh {name}"
    quality = checked_quality(nodes, elements, remedy)
    _check_connected(name, nodes, elements)
    facets = outer_facets(elements)
    surface = Surface(nodes, facets[:, :3], _facet_groups(facets, groups, number))
    patches, points = find_key_points(housing, surface)
    owner = np.full(len(facets), -1)
    for index, (patch, chosen) in enumerate(patches.items()):
        if (taken := owner[chosen] >= 0).any():
            other = list(patches)[int(owner[chosen][taken][0])]
            raise MeshError(f"{name}: {patch} and {other} share {int(taken.sum())} facets; locate them apart")
        owner[chosen] = index
    if element_size is None:
        count("casing_meshes")
    return CasingMesh(
        nodes=nodes,
        elements=elements,
        facets=facets,
        facet_patch=owner,
        patch_names=tuple(patches),
        patch_points=np.array([points[patch] for patch in patches]),
        element_size=mean_edge(nodes, elements) if element_size is None else element_size,
        quality=quality,
        curved=int(curved(nodes, elements).any()),
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
    """MeshError when the bearings of the shafts cannot lie in the file; says which unit would fit."""
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
        f"{Path(housing.path).name} read in {housing.unit} spans {size} mm from ({_mm(placed.min(axis=0))}) mm, but "
        f"the bearings of the shafts span {span} mm from ({_mm(wanted.min(axis=0))}) mm. {remedy}"
    )


def outer_facets(elements: np.ndarray) -> np.ndarray:
    """Faces (f, 6) that belong to one tetrahedron only, normals outwards: corners, then mid-sides 01 12 20."""
    faces = elements[:, _FACES].reshape(-1, 6)
    _, first, times = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    return faces[np.sort(first[times == 1])]


def _check_connected(name: str, nodes: np.ndarray, elements: np.ndarray) -> None:
    """MeshError if the mesh falls into parts that share no node."""
    rows = np.repeat(elements[:, 0], 3)
    graph = sp.coo_matrix((np.ones(len(rows)), (rows, elements[:, 1:4].ravel())), shape=(len(nodes),) * 2)
    label = connected_components(graph, directed=False)[1][elements[:, 0]]
    parts, sizes = np.unique(label, return_counts=True)
    if len(parts) > 1:
        loose = parts[sizes.argmin()]
        x, y, z = nodes[elements[label == loose][:, :4]].mean(axis=(0, 1))
        raise MeshError(
            f"{name} falls into {len(parts)} unconnected parts; the smallest has {sizes.min()} of {len(elements)} "
            f"tetrahedra around x=({x:.4g}, {y:.4g}, {z:.4g}) m. Merge coincident nodes, or leave the loose part out"
        )


def _facet_groups(
    facets: np.ndarray, groups: Mapping[str, tuple[str, np.ndarray]], number: np.ndarray
) -> dict[str, np.ndarray]:
    """Groups of the file as bool (f,) over the outer facets; `number` renumbers the nodes of the file (-1: unused)."""
    found, corners = {}, np.sort(facets[:, :3], axis=1)
    for name, (kind, items) in groups.items():
        if kind == "nodes":
            member = np.isin(np.arange(number.max() + 1), number[items])
            found[name] = member[corners].all(axis=1)
        else:
            wanted = {tuple(corner) for corner in np.sort(number[items], axis=1).tolist()}
            found[name] = np.array([tuple(corner) in wanted for corner in corners.tolist()], bool)
    return found


def seat_point(surface: Surface, seat: Seat, facets: np.ndarray) -> np.ndarray:
    """The bearing point: on the axis, in the middle of the seat; MeshError if it is not where the shaft is."""
    if isinstance(seat.locator, ByCylinder):
        through, axis = np.array(seat.locator.through), np.array(seat.locator.axis)
        point, allowed = axis_place(surface, facets, through, axis), OFF_AXIS
    else:
        corners, axis = surface.corners[facets].reshape(-1, 3), np.array([0.0, 1.0, 0.0])
        fitted = fitted_circle(corners[:, [0, 2]])
        middle, allowed = centroid(surface, facets), OFF_AXIS
        if fitted is not None:
            middle[[0, 2]] = fitted[0]
        else:  # a seat with grooves, or more than the seat in one group: its centroid lies off the axis
            allowed = 0.3 * float(np.linalg.norm((corners - middle)[:, [0, 2]], axis=1).mean())
        point = axis_place(surface, facets, middle, axis)
    if seat.shaft_point is None:
        return point
    wanted = np.array(seat.shaft_point)
    off = float(np.hypot(*(point - wanted)[[0, 2]]))
    tilt = abs(axis[1]) / np.linalg.norm(axis)
    if off > allowed or tilt < ALONG_Y:
        raise MeshError(
            f"{seat.name}: its seat has its middle at ({_mm(point)}) mm and its axis along {tuple(axis.tolist())}, "
            f"{1000 * off:.4g} mm off the axis of its shaft at x {1000 * wanted[0]:.5g}, z {1000 * wanted[2]:.5g} mm "
            f"(limit {1000 * allowed:.3g} mm, along y). Correct the locator, or origin, axes or unit of the file"
        )
    along = surface.corners[facets][..., 1]
    if not along.min() <= wanted[1] <= along.max():
        raise MeshError(
            f"{seat.name}: the bearing at y = {1000 * wanted[1]:.5g} mm is outside its seat "
            f"({1000 * along.min():.5g} to {1000 * along.max():.5g} mm). Move the bearing, or correct the locator"
        )
    return np.array([wanted[0], point[1], wanted[2]])


def _mm(point: np.ndarray) -> str:
    return ", ".join(f"{1000 * value:.5g}" for value in point)
