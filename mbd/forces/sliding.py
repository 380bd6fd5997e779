"""Sliding friction of the teeth, which reverses where a pair passes the pitch point.

A tooth pair at the distance xi from the pitch point slides at (phi1' + phi2') xi along m = s (y x n), and mu F_p
opposes it on both gears. With m . (u1 - u2) at the pitch point as w and kappa = phi1 + phi2 the generalised forces are

    -mu F S(c) on w      -mu F Q(c) on kappa      S = sum of shares times sign xi      Q = sum of shares times |xi|

The shares (of pairs and places along the face) are those of error-free gears at the nominal load at rest, tabulated
over the mesh cycle; friction does not act along the face. It reverses with the speed as tanh(omega/omega_0), see
`mbd.parts.losses`.

References
----------
Vaishya & Singh (2001), J. Sound Vib. 248(4), 671-694.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mbd.elements.element import Element, rule
from mbd.forces.flank import SIDES, flank_name
from mbd.parts.coordinate_layout import Layout
from mbd.parts.gear_mesh import MeshSpec
from mbd.parts.linear_reference import Assembly
from mbd.parts.mesh_reference import sliding_shares
from mbd.parts.shafts import ShaftSpec

FRICTION, ROLL, SMOOTH, CYCLE_START, CYCLE_RATE, SHARES = range(6)


@rule(__file__)
def sliding_rule(values, motion, answer):
    """Force on w and torque on kappa of one flank, which it reads; ``values`` end with S, then Q over the cycle."""
    total = motion.v[1] + values[ROLL] * motion.speed
    s = math.tanh(total / values[SMOOTH])
    ds = (1.0 - s * s) / values[SMOOTH]
    cycle = values[CYCLE_START] + values[CYCLE_RATE] * motion.angle
    n = (len(values) - SHARES) // 2
    place = (cycle - math.floor(cycle)) * n
    i = int(place) % n
    part = place - math.floor(place)
    for r in range(2):
        first = SHARES + r * n
        share = values[FRICTION] * ((1.0 - part) * values[first + i] + part * values[first + (i + 1) % n])
        answer.lost[r] = share * motion.read_force[0] * s
        answer.lost_by_u[r, 2] = share * motion.read_stiffness[0, 0] * s
        answer.lost_by_u[r, 3] = share * motion.read_stiffness[0, 1] * s
        answer.lost_by_v[r, 1] = share * motion.read_force[0] * ds


def sliding_rows(mesh: MeshSpec, driving: ShaftSpec, driven: ShaftSpec, flank: int) -> np.ndarray:
    """Rows (2, 12): w and kappa on (ux uy uz rx ry rz) of the driving, then the driven gear.

    Parameters
    ----------
    mesh, driving, driven : the mesh and the shafts of its gears
    flank : +1 drive, -1 coast
    """
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


def elements(assembly: Assembly) -> Iterator[Element]:
    """One per flank, where teeth rub."""
    friction, ratios = assembly.machine.losses.tooth_friction, assembly.layout.ratios
    if friction == 0.0:
        return
    for mesh in assembly.machine.meshes:
        load, roll = assembly.mesh_loads[mesh.name], ratios[mesh.driving] + ratios[mesh.driven]
        cycle = mesh.cycle_at_start, mesh.cycles_per_radian * ratios[mesh.driving]
        for side, name in enumerate(SIDES):
            shares = sliding_shares((mesh.drive, mesh.coast)[side], load)
            yield Element(
                kind="sliding",
                name=f"{mesh.name} losses:{name}",
                part=f"{mesh.name} losses",
                rule=sliding_rule,
                values=np.array([friction, roll, assembly.smoothing * roll, *cycle, *shares.ravel()]),
                rows=mesh_sliding_rows(assembly.layout, mesh, 1 - 2 * side),
                row_names=("w", "kappa"),
                scale=(load, load * mesh.base_radius_driving),
                reads=(flank_name(mesh.name, side),),
                rolls=True,
            )
