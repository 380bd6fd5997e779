"""Losses of meshes and bearings: rungs `none`, `efficiency`, `coulomb`; and the holding brake. All are internal
torques.

`efficiency`: with the mesh force F a pair of torques tau = F r_b1 x opposes the rotation of both gears, so that what
comes out is eta times what goes in. From (1 - x i)/(1 + x) = eta with i = r_b1/r_b2,

    x = (1 - eta)/(eta + i)      the driving gear gives the power
    x = (1 - eta)/(1 + eta i)    the driven gear gives it (the load lowers; or the coast flank in lifting)

and the power tau (phi1' + phi2') is lost. The torques are equal and turn with phi1 and phi2, which have opposite senses
in space: they need no reaction in the casing.

`coulomb`: a tooth pair at the distance xi from the pitch point slides at (phi1' + phi2') xi along m = s (y x n), and mu
F_p opposes it on both gears. With m . (u1 - u2) at the pitch point as w and kappa = phi1 + phi2 the generalised forces
are

    -mu F S(c) on w      -mu F Q(c) on kappa      S = sum of shares times sign xi      Q = sum of shares times |xi|

so that the force reverses where a pair passes the pitch point. The shares (of pairs and places along the face) are
those of error-free gears at the nominal load at rest, tabulated over the mesh cycle; friction does not act along the
face. A bearing drags with mu_b P d/2: P its load at rest, d the shaft's diameter in it; the casing's reaction to it is
left out.

All reverse smoothly with the speed omega of the element, as tanh(omega/omega_0); omega_0 is ``SMOOTHING`` of the
highest speed in the run. At rest nothing is lost and nothing is held by friction.

References
----------
Niemann & Winter (2003), Maschinenelemente II, 21.10 (mesh losses); Vaishya & Singh (2001), J. Sound Vib. 248(4),
671-694 (sliding friction that reverses at the pitch point); SKF (2018), Rolling Bearings, p. 132 (M = 0.5 mu P d).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.compiled import inner
from mbd.checks import MachineError, not_negative
from mbd.gear_mesh import MeshSpec
from mbd.shafts import ShaftSpec

SMOOTHING = 0.02  # of the highest speed


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


@inner()
def efficiency_loss(values, speed, rate, force, f_d, f_p, slope_u, slope_v):
    """Torque on kappa times -1; slopes by (drive delta, psi, coast delta, psi) and by kappa'; power lost.

    force, f_d, f_p : (2,) of drive and coast flank.
    """
    eta, radius, ratio, roll, smooth = values[0], values[1], values[2], values[3], values[4]
    total = rate + roll * speed
    s = math.tanh(total / smooth)
    ds = (1.0 - s * s) / smooth
    forth, back = (1.0 - eta) / (eta + ratio), (1.0 - eta) / (1.0 + eta * ratio)
    torque, slope = 0.0, 0.0
    for k in range(2):
        way = s if k == 0 else -s
        x = 0.5 * ((1.0 + way) * forth + (1.0 - way) * back)
        dx = 0.5 * (forth - back) * (ds if k == 0 else -ds)
        share = radius * x * s
        torque += share * force[k]
        slope += radius * force[k] * (x * ds + dx * s)
        slope_u[2 * k] = share * f_d[k]
        slope_u[2 * k + 1] = share * f_p[k]
    slope_v[0] = slope
    return torque, torque * total


@inner()
def tooth_friction(values, shares, cycle, speed, rate_w, rate_kappa, force, f_d, f_p, out, slope_u, slope_v):
    """Forces (2,) on w, kappa of one flank times -1, slopes by (delta, psi) (2, 2) and by kappa' (2,); power lost."""
    mu, roll, smooth = values[0], values[1], values[2]
    total = rate_kappa + roll * speed
    s = math.tanh(total / smooth)
    ds = (1.0 - s * s) / smooth
    n = shares.shape[1]
    place = (cycle - math.floor(cycle)) * n
    i = int(place) % n
    part = place - math.floor(place)
    for r in range(2):
        share = mu * ((1.0 - part) * shares[r, i] + part * shares[r, (i + 1) % n])
        out[r] = share * force * s
        slope_u[r, 0] = share * f_d * s
        slope_u[r, 1] = share * f_p * s
        slope_v[r] = share * force * ds
    return out[0] * rate_w + out[1] * total


@inner()
def drag(values, speed, rate):
    """Torque of a drag or brake times -1, its slope by the rate, the power lost."""
    torque, roll, smooth, closing = values[0], values[1], values[2], values[3]
    if closing > 0.0:  # a brake
        rest = 1.0 - (speed / closing) ** 2
        if rest <= 0.0:
            return 0.0, 0.0, 0.0
        torque *= rest * rest
    total = rate + roll * speed
    s = math.tanh(total / smooth)
    return torque * s, torque * (1.0 - s * s) / smooth, torque * s * total
