"""Shafts: stepped beams along y with disks; rungs `timoshenko` and `torsion`.

A node has six displacements (ux, uy, uz, rx, ry, rz) in global axes. An element of length L carries axial and
torsional stiffness EA/L, GJ/L and, in the two planes (uz, rx) and (ux, -rz), the shear-flexible beam with
interdependent shape functions (exact for end loads), consistent mass and rotary inertia. Gyroscopic moments are in
`mbd.parts.gyroscopic`.

`torsion` keeps the twist of the same elements but moves otherwise as a rigid body (five displacements per shaft), so
that bearings, casing and sensors are still excited: its matrices are T^T M T and T^T K T of the beam.

References
----------
Przemieniecki (1968), Theory of Matrix Structural Analysis, sections 5.6 and 11.6 (stiffness and mass of the beam);
Friedman & Kosmatka (1993), Computers & Structures 47(3), 473-481 (shape functions);
Cowper (1966), J. Appl. Mech. 33(2), 335-340 (shear coefficient of the hollow circle).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mbd.parts.checks import MachineError, finite, not_negative, positive, unique

AXES = ("ux", "uy", "uz", "rx", "ry", "rz")
MOST_NODES = 333  # of a shaft: just below 2000 coordinates, whose matrices take 32 MB each


@dataclass(frozen=True, kw_only=True)
class Section:
    """A length of shaft with constant diameters (m)."""

    y_start: float
    y_end: float
    outer_diameter: float
    inner_diameter: float = 0.0

    def __post_init__(self) -> None:
        positive("section length", self.y_end - self.y_start, "Let y_end exceed y_start.")
        positive("section outer_diameter", self.outer_diameter)
        not_negative("section inner_diameter", self.inner_diameter)
        if self.inner_diameter >= self.outer_diameter:
            raise MachineError(
                f"section: inner diameter {self.inner_diameter} m is not below the outer {self.outer_diameter} m."
            )


@dataclass(frozen=True, kw_only=True)
class Disk:
    """A rigid disk on a shaft: gear body, drum or coupling half (kg, kg m2)."""

    name: str
    y: float
    mass: float
    polar_inertia: float
    diametral_inertia: float

    def __post_init__(self) -> None:
        finite(f"disk {self.name} y", self.y)
        not_negative(f"disk {self.name} mass", self.mass)
        not_negative(f"disk {self.name} polar_inertia", self.polar_inertia)
        not_negative(f"disk {self.name} diametral_inertia", self.diametral_inertia)


@dataclass(frozen=True, kw_only=True)
class ShaftSpec:
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
    model: Literal["timoshenko", "torsion"] = "timoshenko"
    elastic_modulus: float = 206e9
    poisson_ratio: float = 0.3
    density: float = 7850.0
    damping_time: float = 1e-6
    element_length: float = 0.05

    def __post_init__(self) -> None:
        where = f"shaft {self.name}"
        finite(f"{where} x", self.x)
        finite(f"{where} z", self.z)
        if self.sense not in (1, -1):
            raise MachineError(f"{where}: sense {self.sense!r} must be +1 or -1 (lifting rotation about +y or -y).")
        if self.model not in ("timoshenko", "torsion"):
            raise MachineError(f"{where}: model {self.model!r} is unknown; known: timoshenko, torsion.")
        if not self.sections:
            raise MachineError(f"{where}: has no section; give at least one.")
        for before, after in itertools.pairwise(self.sections):
            if abs(before.y_end - after.y_start) > 1e-9:
                raise MachineError(
                    f"{where}: sections must follow one another, but one ends at {before.y_end} m and the next "
                    f"starts at {after.y_start} m."
                )
        positive(f"{where} elastic_modulus", self.elastic_modulus)
        positive(f"{where} density", self.density)
        positive(f"{where} element_length", self.element_length)
        not_negative(f"{where} damping_time", self.damping_time)
        if not -1.0 < self.poisson_ratio < 0.5:
            raise MachineError(f"{where}: poisson_ratio {self.poisson_ratio} must lie between -1 and 0.5.")
        unique(f"{where} disks", [d.name for d in self.disks])
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
        """Raise MachineError if ``y`` is off the shaft."""
        if not self.y_start - 1e-9 <= y <= self.y_end + 1e-9:
            raise MachineError(
                f"{what}: y = {y} m is off {self.name}, which reaches from {self.y_start} to {self.y_end} m."
            )


def torsional_stiffness(spec: ShaftSpec) -> float:
    """Torque over twist (N m/rad) of the whole shaft."""
    modulus = spec.elastic_modulus / (2 * (1 + spec.poisson_ratio))
    twist = sum(
        (s.y_end - s.y_start) / max(s.outer_diameter**4 - s.inner_diameter**4, np.finfo(float).tiny)
        for s in spec.sections
    )
    return float(modulus * np.pi / 32 / twist)


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
            f"{spec.y_end - spec.y_start:.6g} m long in elements of at most {spec.element_length:.4g} m. Raise "
            "element_length (element_length_mm of the scene's shaft_model), or shorten the shaft."
        )
    nodes = [points[:1]]
    for a, b, n in zip(points[:-1], points[1:], pieces.astype(int), strict=True):
        nodes.append(a + (b - a) * np.arange(1, n + 1) / n)
    return np.concatenate(nodes)


def node_at(nodes: np.ndarray, y: float) -> int:
    """Index of the node at ``y`` (it exists: every station is a node)."""
    return int(np.argmin(abs(nodes - y)))


def shaft_matrices(spec: ShaftSpec, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness (6 node, 6 node) of the free shaft with its disks, SI."""
    size = 6 * len(nodes)
    mass, stiffness = np.zeros((size, size)), np.zeros((size, size))
    for e in range(len(nodes) - 1):
        m, k = beam_element(spec, section_at(spec, nodes, e), float(nodes[e + 1] - nodes[e]))
        span = slice(6 * e, 6 * e + 12)
        mass[span, span] += m
        stiffness[span, span] += k
    for disk in spec.disks:
        at = 6 * node_at(nodes, disk.y)
        inertia = (disk.mass,) * 3 + (disk.diametral_inertia, disk.polar_inertia, disk.diametral_inertia)
        mass[range(at, at + 6), range(at, at + 6)] += inertia
    return mass, stiffness


def shaft_basis(spec: ShaftSpec, nodes: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """T (6 node, coordinate) with node displacements = T q, and the coordinate names of the rung ``spec.model``."""
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


def beam_element(spec: ShaftSpec, section: Section, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness (12, 12) of one element along y, node order (ux uy uz rx ry rz) twice."""
    e_modulus, nu, rho = spec.elastic_modulus, spec.poisson_ratio, spec.density
    g_modulus = e_modulus / (2 * (1 + nu))
    d, d_i = section.outer_diameter, section.inner_diameter
    area, second_moment = math.pi * (d**2 - d_i**2) / 4, math.pi * (d**4 - d_i**4) / 64
    polar = 2 * second_moment
    phi = _shear_share(spec, section, length)

    mass, stiffness = np.zeros((12, 12)), np.zeros((12, 12))
    pair_m, pair_k = np.array([[2, 1], [1, 2]]) * length / 6, np.array([[1, -1], [-1, 1]]) / length
    axial, torsion = np.ix_((1, 7), (1, 7)), np.ix_((4, 10), (4, 10))
    mass[axial], stiffness[axial] = rho * area * pair_m, e_modulus * area * pair_k
    mass[torsion], stiffness[torsion] = rho * polar * pair_m, g_modulus * polar * pair_k

    bend_m, bend_k = _bending(length, phi, e_modulus * second_moment, rho * area, rho * second_moment)
    for dofs, signs in (((2, 3, 8, 9), (1, 1, 1, 1)), ((0, 5, 6, 11), (1, -1, 1, -1))):
        flip = np.outer(signs, signs)
        mass[np.ix_(dofs, dofs)] += bend_m * flip
        stiffness[np.ix_(dofs, dofs)] += bend_k * flip
    return mass, stiffness


def rotary_inertia(spec: ShaftSpec, nodes: np.ndarray) -> list[tuple[int, np.ndarray]]:
    """First coordinate and rotary inertia (4, 4) over (v1, theta1, v2, theta2) of every element, SI."""
    found = []
    for e in range(len(nodes) - 1):
        section, length = section_at(spec, nodes, e), float(nodes[e + 1] - nodes[e])
        second_moment = math.pi * (section.outer_diameter**4 - section.inner_diameter**4) / 64
        found.append(
            (6 * e, _bending(length, _shear_share(spec, section, length), 0.0, 0.0, spec.density * second_moment)[0])
        )
    return found


def section_at(spec: ShaftSpec, nodes: np.ndarray, element: int) -> Section:
    """The section that an element lies in."""
    middle = 0.5 * (nodes[element] + nodes[element + 1])
    return next(s for s in spec.sections if s.y_start - 1e-9 <= middle <= s.y_end + 1e-9)


def _shear_share(spec: ShaftSpec, section: Section, length: float) -> float:
    """12 E I/(kappa G A L^2): shear over bending flexibility."""
    d, d_i = section.outer_diameter, section.inner_diameter
    kappa = shear_coefficient(spec.poisson_ratio, d_i / d)
    return 12 * 2 * (1 + spec.poisson_ratio) * (d**2 + d_i**2) / 16 / (kappa * length**2)


def shear_coefficient(nu: float, m: float) -> float:
    """Cowper's kappa of a circle with the bore ratio m = d_i/d_o."""
    q = (1 + m * m) ** 2
    return 6 * (1 + nu) * q / ((7 + 6 * nu) * q + (20 + 12 * nu) * m * m)


def _bending(length: float, phi: float, ei: float, rho_a: float, rho_i: float) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness (4, 4) in (v1, theta1, v2, theta2) with theta = dv/dy for a slender beam."""
    mu = 1 / (1 + phi)
    k = np.array([[12, 6, -12, 6], [6, 4 + phi, -6, 2 - phi], [-12, -6, 12, -6], [6, 2 - phi, -6, 4 + phi]])
    scale = np.array([1, length, 1, length])
    stiffness = ei * mu / length**3 * k * np.outer(scale, scale)
    points, weights = np.polynomial.legendre.leggauss(4)  # exact to degree 7, the product has degree 6
    mass = np.zeros((4, 4))
    for s, w in zip(0.5 * (points + 1), 0.5 * length * weights, strict=True):
        bubble = s - s * s
        v = mu * np.array(
            [
                1 - 3 * s**2 + 2 * s**3 + phi * (1 - s),
                length * (s - 2 * s**2 + s**3 + phi / 2 * bubble),
                3 * s**2 - 2 * s**3 + phi * s,
                length * (-(s**2) + s**3 - phi / 2 * bubble),
            ]
        )
        theta = mu * np.array(
            [
                -6 / length * bubble,
                1 - 4 * s + 3 * s**2 + phi * (1 - s),
                6 / length * bubble,
                -2 * s + 3 * s**2 + phi * s,
            ]
        )
        mass += w * (rho_a * np.outer(v, v) + rho_i * np.outer(theta, theta))
    return mass, stiffness
