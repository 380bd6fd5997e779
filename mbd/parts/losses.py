"""Losses of meshes and bearings: rungs `none`, `efficiency`, `coulomb`; and the holding brake. All are internal
torques.

The forces stand in `mbd.forces`: `efficiency`, `sliding`, `drag`. All reverse smoothly with the speed omega of the
element, as tanh(omega/omega_0); omega_0 is a share of the highest speed in the run (`mbd.forces.assembly`). At rest
nothing is lost and nothing is held by friction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from mbd.parts.checks import MachineError, not_negative
from mbd.parts.gear_mesh import MeshSpec
from mbd.parts.shafts import ShaftSpec

if TYPE_CHECKING:
    from mbd.coordinates.layout import Layout


@dataclass(frozen=True, kw_only=True)
class NoLosses:
    """Nothing is lost in meshes and bearings."""

    model: Literal["none"] = "none"


@dataclass(frozen=True, kw_only=True)
class Efficiency:
    """Every mesh passes on the share ``mesh_efficiency`` of the power that enters it."""

    mesh_efficiency: float
    model: Literal["efficiency"] = "efficiency"

    def __post_init__(self) -> None:
        if not 0.5 < self.mesh_efficiency <= 1.0:
            raise MachineError(f"losses: mesh_efficiency {self.mesh_efficiency!r} must be above 0.5 and at most 1.")


@dataclass(frozen=True, kw_only=True)
class Coulomb:
    """Sliding friction of the teeth and drag of the bearings, as shares of the normal loads."""

    tooth_friction: float
    bearing_friction: float = 0.0
    model: Literal["coulomb"] = "coulomb"

    def __post_init__(self) -> None:
        not_negative("losses tooth_friction", self.tooth_friction)
        not_negative("losses bearing_friction", self.bearing_friction)
        if max(self.tooth_friction, self.bearing_friction) > 1.0:
            raise MachineError("losses: friction above 1 is no sliding friction of steel.")


Losses = NoLosses | Efficiency | Coulomb


@dataclass(frozen=True, kw_only=True)
class Brake:
    """A holding brake of the given torque (N m) at ``y`` of ``shaft``: closed while the motors stand."""

    shaft: str
    y: float
    torque: float

    def __post_init__(self) -> None:
        not_negative("brake torque", self.torque)


def sliding_rows(mesh: MeshSpec, driving: ShaftSpec, driven: ShaftSpec, flank: int) -> np.ndarray:
    """Rows (2, 12): w and kappa on (ux uy uz rx ry rz) of driving, then driven gear; flank +1 drive, -1 coast."""
    line = np.array([driven.x - driving.x, 0.0, driven.z - driving.z])
    e, up, s = line / np.linalg.norm(line), np.array([0.0, 1.0, 0.0]), driving.sense
    n = flank * s * math.cos(mesh.pressure_angle) * np.cross(up, e) + math.sin(mesh.pressure_angle) * e
    m = s * np.cross(up, n)
    rows = np.zeros((2, 12))
    for gear, (sign, radius) in enumerate(((1, mesh.base_radius_driving), (-1, mesh.base_radius_driven))):
        at = 6 * gear
        rows[0, at : at + 3] = sign * m
        rows[0, at + 3 : at + 6] = radius / math.cos(mesh.pressure_angle) * np.cross(e, m)
        rows[1, at + 4] = sign * s
    return rows


def mesh_sliding_rows(lay: Layout, mesh: MeshSpec, flank: int) -> np.ndarray:
    """`sliding_rows` (2, coordinate) of a mesh in its machine."""
    driving, driven = lay.machine.shaft(mesh.driving), lay.machine.shaft(mesh.driven)
    return np.array(
        [
            lay.node_row(mesh.driving, mesh.y, row[:6]) + lay.node_row(mesh.driven, mesh.y, row[6:])
            for row in sliding_rows(mesh, driving, driven, flank)
        ]
    )
