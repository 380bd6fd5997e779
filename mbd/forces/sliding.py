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
from typing import TYPE_CHECKING

import numpy as np

from mbd.forces.element import Element, rule
from mbd.forces.flank import SIDES, flank_name
from mbd.parts.losses import Coulomb, mesh_sliding_rows
from mbd.parts.mesh_reference import sliding_shares

if TYPE_CHECKING:
    from mbd.forces.assembly import Assembly

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


def elements(assembly: Assembly) -> Iterator[Element]:
    """One per flank, where teeth rub."""
    losses, ratios = assembly.machine.losses, assembly.ratios
    if not isinstance(losses, Coulomb) or losses.tooth_friction == 0.0:
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
                values=np.array([losses.tooth_friction, roll, assembly.smoothing * roll, *cycle, *shares.ravel()]),
                rows=mesh_sliding_rows(assembly.layout, mesh, 1 - 2 * side),
                row_names=("w", "kappa"),
                scale=(load, load * mesh.base_radius_driving),
                reads=(flank_name(mesh.name, side),),
                rolls=True,
            )
