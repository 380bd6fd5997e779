"""Gear mesh: the rows that turn the motion of two gears into (delta, psi) of each flank, and the force law on them.

With the unit centre line e from the driving to the driven axis, t = y x e and the lifting sense s of the driving
shaft, the unit vector along the transverse line of action of the drive flank (the force on the driven gear) is
n = s cos(alpha) t + sin(alpha) e; the coast flank has n = -s cos(alpha) t + sin(alpha) e. The force has the axial part
a = -h tan(beta_b) along s y, where h is the hand of the driving gear (+1 right) and is reversed on the coast flank:
it is perpendicular to the contact lines, whose shift along n is h tan(beta_b) per face coordinate. With
N = n + a s y and the pitch point as the point of contact,

    delta = N . (u_1 - u_2) +- (r_b1 phi_1 - r_b2 phi_2) - a s t . (r_1 theta_1 + r_2 theta_2) (tilts, r_i pitch radii)
    psi   = s (y x n) . (theta_1 - theta_2)

The face coordinate of a law therefore points along the rotation vector of the driving gear in lifting (right-hand
rule). The generalised forces -F, -M act through the same rows. With damping the force is F_t = max(0, F + tau k_t d)
with d = delta' + (M/F) psi', the approach rate at the force centroid, and M_t = M F_t/F: the contact never pulls, and
its dissipation (F_t - F) d is never negative.

References
----------
ISO 21771-1:2024 (base helix, transverse line of action); the same rows follow for spur gears with beta_b = 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from fem.contact.law import MeshLaw
from fem.contact.teeth import checked_terms
from mbd.elements.component import Component, Link, Place
from mbd.parts.oil_film import Film
from mbd.parts.shafts import ShaftSpec


def mesh_channels(mesh: str) -> tuple[str, str, str, str]:
    """delta (m) and psi (rad) of the drive flank, force (N) of drive and coast flank, damping included."""
    return f"{mesh}:delta", f"{mesh}:psi", f"{mesh}:drive_force", f"{mesh}:coast_force"


@dataclass(frozen=True, eq=False, kw_only=True)
class GearedShafts(Component):
    """Where a gear pair is: its gears on the shafts `driving` and `driven`, mid face at `y` (m).

    `cycle_at_start` is the mesh cycle at t = 0; `damping_time` tau (s) gives damping = tau * stiffness.
    """

    name: str
    driving: str
    driven: str
    y: float
    damping_time: float
    cycle_at_start: float = 0.0
    film: Film | None = None

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Approach, tilt and forces."""
        return mesh_channels(self.name)

    def meshing(self, **pair: Any) -> MeshSpec:
        """The mesh here; `pair` are the values of its gears and laws."""
        return MeshSpec(**{item.name: getattr(self, item.name) for item in fields(GearedShafts)}, **pair)


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshSpec(GearedShafts):
    """A gear pair with its laws; the driving gear is their pinion.

    Radii in m, angles in rad, ``backlash`` (m) along the transverse line of action.
    Clearances (tooth,), m, +inf for a missing tooth, or tooth terms (tooth, 6) of `fem.contact.teeth`; empty arrays
    mean no deviation. They are kept as tooth terms.
    """

    base_radius_driving: float
    base_radius_driven: float
    pressure_angle: float  # transverse, working
    base_helix_angle: float  # >= 0; the hand is in the law
    backlash: float
    drive: MeshLaw
    coast: MeshLaw
    drive_clearance_pinion: np.ndarray = field(default_factory=lambda: np.zeros(0))
    drive_clearance_wheel: np.ndarray = field(default_factory=lambda: np.zeros(0))
    coast_clearance_pinion: np.ndarray = field(default_factory=lambda: np.zeros(0))
    coast_clearance_wheel: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        for gear, teeth in (("pinion", self.drive.pinion_teeth), ("wheel", self.drive.wheel_teeth)):
            for flank in ("drive", "coast"):
                name = f"{flank}_clearance_{gear}"
                given = getattr(self, name)
                terms = checked_terms(gear, teeth, given if len(given) else None)
                terms.flags.writeable = False
                object.__setattr__(self, name, terms)

    @property
    def terms(self) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
        """Tooth terms of pinion and wheel on the drive flank, then on the coast flank."""
        return (
            (self.drive_clearance_pinion, self.drive_clearance_wheel),
            (self.coast_clearance_pinion, self.coast_clearance_wheel),
        )

    @property
    def cycles_per_radian(self) -> float:
        """Mesh cycles per radian of the driving shaft, z1/(2 pi)."""
        return self.drive.pinion_teeth / (2 * math.pi)

    @property
    def ratio(self) -> float:
        """Speed of the driven over the driving shaft."""
        return self.base_radius_driving / self.base_radius_driven

    @property
    def places(self) -> tuple[Place, ...]:
        """Both gears."""
        return tuple(Place(f"mesh {self.name}", shaft, self.y) for shaft in (self.driving, self.driven))

    @property
    def links(self) -> tuple[Link, ...]:
        """The driven gear turns at the ratio of the teeth."""
        return (Link(f"mesh {self.name}", self.driving, self.driven, self.ratio),)

    def turned(self, angle: float) -> MeshSpec:
        """The mesh after its driving gear has rolled by ``angle`` (rad)."""
        return replace(self, cycle_at_start=self.cycle_at_start + self.cycles_per_radian * angle)


def mesh_rows(mesh: MeshSpec, driving: ShaftSpec, driven: ShaftSpec) -> np.ndarray:
    """Rows (4, 12): delta, psi of drive, then coast, on (ux uy uz rx ry rz) of the driving, then the driven gear."""
    line = (driven.x - driving.x, driven.z - driving.z)
    radii = mesh.base_radius_driving, mesh.base_radius_driven
    shift = mesh.drive.cycle_shift
    hand = float(np.sign(shift[-1] - shift[0]))
    return contact_rows(line, radii, mesh.pressure_angle, hand * math.tan(mesh.base_helix_angle), driving.sense)


def contact_rows(
    line: tuple[float, float], radii: tuple[float, float], pressure_angle: float, lead: float, sense: int
) -> np.ndarray:
    """The rows (4, 12) of `mesh_rows` by dimensions.

    Parameters
    ----------
    line : (x, z) from the driving to the driven axis, m; only its direction counts
    radii : base radii of driving and driven gear, m
    pressure_angle : transverse, working, rad
    lead : tangent of the base helix angle, positive for a right-hand driving gear
    sense : lifting sense of the driving shaft, +1 or -1
    """
    e = np.array([line[0], 0.0, line[1]]) / math.hypot(*line)
    up, s = np.array([0.0, 1.0, 0.0]), sense
    t = np.cross(up, e)
    rows = np.zeros((4, 12))
    for k, flank in enumerate((1, -1)):
        n = flank * s * math.cos(pressure_angle) * t + math.sin(pressure_angle) * e
        axial = -flank * lead
        force = n + axial * s * up
        for gear, (sign, radius) in enumerate(zip((1, -1), radii, strict=True)):
            at = 6 * gear
            pitch = radius / math.cos(pressure_angle)
            rows[2 * k, at : at + 3] = sign * force
            # moment of N about the gear centre: r_b about y, and the axial part at the pitch point tilts about t
            rows[2 * k, at + 3 : at + 6] = flank * s * radius * up - axial * s * pitch * t
            rows[2 * k + 1, at + 3 : at + 6] = sign * s * np.cross(up, n)
    return rows
