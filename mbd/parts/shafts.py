"""Shafts: stepped beams along y with disks; models `timoshenko` and `torsion`.

A node has six displacements (ux, uy, uz, rx, ry, rz) in global axes. The matrices of sections and disks are those of
`mbd.parts.beam`.

`torsion` keeps the twist of the same elements but otherwise moves as a rigid body (five displacements per shaft), so
that it still excites bearings, casing and sensors: its matrices are T^T M T and T^T K T of the beam.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.options import check_options, option
from mbd.elements.channel_reading import Reading
from mbd.elements.component import Component
from mbd.elements.coordinates import Coordinates, node_at
from mbd.elements.linear_part import Matrices, Part
from mbd.elements.mode_words import ModeWords
from mbd.parts.beam import beam_matrices, disk_matrices
from mbd.parts.part_checks import MachineError, Options

AXES = ("ux", "uy", "uz", "rx", "ry", "rz")
RIGID_MOTIONS = 5  # of the model "torsion", its first coordinates
WORDS = ModeWords("shaft", "shafts")
MOST_NODES = 333  # of a shaft: just below 2000 coordinates, whose matrices take 32 MB each


def shaft_channels(shaft: str) -> tuple[str, str]:
    """Channels of angle (rad) and speed (rad/s) in the lifting sense, at the shaft's first gear or its first end."""
    return f"{shaft}:angle", f"{shaft}:speed"


@dataclass(frozen=True, kw_only=True)
class Section:
    """A stretch of a shaft with constant diameters.

    In m. MachineError if the dimensions contradict one another.
    """

    y_start: float = option(text="y of the -y end", unit="mm", key="start_mm", ge=-1e5, le=1e5)
    y_end: float = option(text="y of the +y end", unit="mm", key="end_mm", ge=-1e5, le=1e5)
    outer_diameter: float = option(text="outer diameter", unit="mm", key="diameter_mm", ge=0.1, le=1e5)
    inner_diameter: float = option(0.0, text="inner diameter", unit="mm", key="bore_mm", ge=0)

    def __post_init__(self) -> None:
        check_options(self, MachineError)
        if self.y_end <= self.y_start:
            raise MachineError(
                f"end_mm = {1000 * self.y_end:g} must be greater than start_mm = {1000 * self.y_start:g}. Correct them"
            )
        if self.inner_diameter >= self.outer_diameter:
            raise MachineError(
                f"bore_mm = {1000 * self.inner_diameter:g} must be smaller than diameter_mm = "
                f"{1000 * self.outer_diameter:g}. Correct them"
            )


@dataclass(frozen=True, kw_only=True)
class Disk(Options):
    """A rigid disk on a shaft, besides gears and drums: half of a coupling, brake disk, flywheel.

    In m, kg and kg m2. The bodies of gears and drums are also disks, which the program creates.
    """

    name: str
    y: float = option(text="y of the disk", unit="mm", key="position_mm")
    mass: float = option(text="mass of the disk", unit="kg", ge=0)
    polar_inertia: float = option(text="moment of inertia about the shaft", unit="kg m2", ge=0)
    diametral_inertia: float = option(text="moment of inertia about a diameter", unit="kg m2", ge=0)


@dataclass(frozen=True, kw_only=True)
class ShaftModel:
    """Model of all shafts."""

    model: Literal["torsion", "timoshenko"] = option(
        "timoshenko", text="torsion: only torsion is elastic; timoshenko: Timoshenko beam elements"
    )
    element_length: float = option(0.04, text="longest beam element", unit="mm", gt=0)
    damping_time: float = option(0.5e-6, text="material damping divided by stiffness", unit="us", ge=0, le=1000)


@dataclass(frozen=True, kw_only=True)
class ShaftSpec(ShaftModel, Component):
    """A shaft whose axis is the line (x, y, z), y along it.

    ``sense`` is +1 if the lifting rotation is about +y and -1 if about -y; phi is positive in the lifting sense.
    ``damping_time`` tau (s) gives material damping C = tau K, i.e. a damping ratio tau omega/2 of the free shaft.
    """

    name: str
    x: float
    z: float
    sense: int
    sections: tuple[Section, ...]
    disks: tuple[Disk, ...] = ()
    elastic_modulus: float = 206e9
    poisson_ratio: float = 0.3
    density: float = 7850.0

    def __post_init__(self) -> None:
        check_options(self, MachineError)
        for disk in self.disks:
            self.check_station(f"disk {disk.name}", disk.y)

    @property
    def y_start(self) -> float:
        """First end (m)."""
        return self.sections[0].y_start

    @property
    def y_end(self) -> float:
        """Last end (m)."""
        return self.sections[-1].y_end

    def check_station(self, what: str, y: float) -> None:
        """Raise MachineError if ``y`` is not on the shaft."""
        if not self.y_start - 1e-9 <= y <= self.y_end + 1e-9:
            raise MachineError(
                f"{what}: y = {1000 * y:g} mm is not on {self.name}, which extends from {1000 * self.y_start:g} to "
                f"{1000 * self.y_end:g} mm."
            )

    def section_at(self, y: float) -> Section:
        """The section at ``y`` (m), the first of two that meet there."""
        return next(s for s in self.sections if s.y_start - 1e-9 <= y <= s.y_end + 1e-9)

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Angle and speed."""
        return shaft_channels(self.name)

    def parts(self, lay: Coordinates) -> Iterator[Part]:
        """The beam and its disks."""
        yield Part(
            name=self.name,
            words=WORDS,
            matrices=shaft_matrices(self, lay.shaft_nodes[self.name]),
            index=lay.index(self.name),
            shape=lay.bases[self.name],
            unstrained=0 if self.model == "timoshenko" else RIGID_MOTIONS,
            spin=self.sense * lay.ratios[self.name],
        )

    def constant_force(self, lay: Coordinates) -> np.ndarray:
        """Weight of the beam and its disks."""
        nodes, force = lay.shaft_nodes[self.name], np.zeros(lay.size)
        lift = np.tile(np.eye(6)[2], len(nodes))
        mass = free_shaft(self, nodes).own("mass")
        force[lay.index(self.name)] -= lay.gravity * lay.bases[self.name].T @ (mass @ lift)
        return force

    def readings(self, lay: Coordinates) -> dict[str, Reading]:
        """Angle and speed in the lifting sense."""
        row, ratio = lay.angle_row(self.name, lay.read_at(self.name)), lay.ratios[self.name]
        angle, speed = shaft_channels(self.name)
        return {
            angle: Reading("rad", displacement=row, rigid=(ratio, 0.0, 0.0)),
            speed: Reading("rad/s", velocity=row, rigid=(0.0, ratio, 0.0)),
        }


def torsional_stiffness(spec: ShaftSpec) -> float:
    """Torque divided by twist (N m/rad) of the whole shaft."""
    modulus = spec.elastic_modulus / (2 * (1 + spec.poisson_ratio))
    twist = sum(
        (s.y_end - s.y_start) / max(s.outer_diameter**4 - s.inner_diameter**4, np.finfo(float).tiny)
        for s in spec.sections
    )
    return float(modulus * np.pi / 32 / twist)


def flexibility(spec: ShaftSpec, nodes: np.ndarray, y: float, supports: tuple[float, float]) -> float:
    """Deflection per force (m/N) across the simply supported shaft alone.

    Parameters
    ----------
    spec, nodes : the shaft and its nodes (node,), m
    y, supports : nodes (m) of the force and of the supports

    Raises
    ------
    MachineError : the model of the shaft does not bend
    """
    if spec.model != "timoshenko":
        raise MachineError(f"shaft {spec.name}: a shaft of model {spec.model} does not bend; take timoshenko.")
    held = [6 * node_at(nodes, place) + AXES.index("uz") for place in supports]
    bending = np.setdiff1d([6 * node + AXES.index(axis) for node in range(len(nodes)) for axis in ("uz", "rx")], held)
    load = (bending == 6 * node_at(nodes, y) + AXES.index("uz")).astype(float)
    stiffness = free_shaft(spec, nodes).own("stiffness")[np.ix_(bending, bending)]
    return float(load @ np.linalg.solve(stiffness, load))


def shaft_nodes(spec: ShaftSpec, stations: tuple[float, ...] = ()) -> np.ndarray:
    """Node positions y (node,), m: section ends, disks and ``stations``, no gap longer than ``element_length``.

    Raises
    ------
    MachineError : more than MOST_NODES of them
    """
    fixed = [s.y_start for s in spec.sections] + [spec.y_end] + [d.y for d in spec.disks] + list(stations)
    points = np.unique(np.round(np.array(fixed), 9))
    pieces = np.maximum(1, np.ceil(np.diff(points) / spec.element_length - 1e-9))
    if pieces.sum() >= MOST_NODES:
        raise MachineError(
            f"shaft {spec.name}: {6 * (pieces.sum() + 1):.6g} coordinates, more than {6 * MOST_NODES}: it is "
            f"{1000 * (spec.y_end - spec.y_start):.6g} mm long in elements of at most "
            f"{1000 * spec.element_length:.4g} mm. "
            "Raise shaft_model.element_length_mm."
        )
    gaps = zip(points[:-1], points[1:], pieces.astype(int), strict=True)
    return np.concatenate([points[:1], *(a + (b - a) * np.arange(1, n + 1) / n for a, b, n in gaps)])


def shaft_matrices(spec: ShaftSpec, nodes: np.ndarray) -> Matrices:
    """Of beam sections between all ``nodes`` (m) and of the disks, on the displacements (6 node,)."""
    total = np.zeros((4, 6 * len(nodes), 6 * len(nodes)))
    for i, (start, end) in enumerate(itertools.pairwise(nodes)):
        section, at = spec.section_at(0.5 * (start + end)), slice(6 * i, 6 * i + 12)
        total[:, at, at] += beam_matrices(
            float(end - start),
            section.outer_diameter,
            section.inner_diameter,
            modulus=spec.elastic_modulus,
            nu=spec.poisson_ratio,
            density=spec.density,
            damping_time=spec.damping_time,
        )
    for disk in spec.disks:
        first = 6 * node_at(nodes, disk.y)
        at = slice(first, first + 6)
        total[:, at, at] += disk_matrices(disk.mass, disk.polar_inertia, disk.diametral_inertia)
    mass, damping, stiffness, gyroscopic = total
    return Matrices(mass=mass, damping=damping, stiffness=stiffness, gyroscopic=gyroscopic)


def free_shaft(spec: ShaftSpec, nodes: np.ndarray) -> Part:
    """The shaft and its disks on the displacements (6 node,) of its nodes alone."""
    every = 6 * len(nodes)
    matrices = shaft_matrices(spec, nodes)
    return Part(name=spec.name, words=WORDS, matrices=matrices, index=np.arange(every), shape=np.eye(every))


def shaft_basis(spec: ShaftSpec, nodes: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """T (6 node, coordinate) with node displacements = T q, and the coordinate names of the model ``spec.model``."""
    n = len(nodes)
    if spec.model == "timoshenko":
        return np.eye(6 * n), tuple(f"{spec.name}:{i}:{axis}" for i in range(n) for axis in AXES)
    rigid = rigid_body_modes(nodes)[:, [0, 1, 2, 3, 5]]
    twist = np.zeros((6 * n, n))
    twist[6 * np.arange(n) + 4, np.arange(n)] = 1.0
    names = [f"{spec.name}:rigid:{axis}" for axis in ("ux", "uy", "uz", "rx", "rz")]
    return np.hstack([rigid, twist]), (*names, *(f"{spec.name}:{i}:ry" for i in range(n)))


def rigid_body_modes(nodes: np.ndarray) -> np.ndarray:
    """Six rigid-body motions (6 node, 6) about the point y = 0 of the axis, in the order ux uy uz rx ry rz."""
    modes = np.zeros((len(nodes), 6, 6))
    modes[:, range(6), range(6)] = 1.0
    modes[:, 2, 3] = nodes  # theta_x moves +z
    modes[:, 0, 5] = -nodes  # theta_z moves -x
    return modes.reshape(-1, 6)
