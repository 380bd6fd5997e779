"""Mesh efficiency: a pair of torques with which every mesh transmits a given share of its input power.

With the mesh force F a torque tau = F r_b1 x opposes the rotation of each gear, so that the output power is eta times
the input power. From (1 - x i)/(1 + x) = eta with i = r_b1/r_b2,

    x = (1 - eta)/(eta + i)      power from the driving to the driven gear
    x = (1 - eta)/(1 + eta i)    power from the driven to the driving gear (lowering; or the coast flank in lifting)

and the power tau (phi1' + phi2') is lost. Both torques are equal, and phi1 and phi2 have opposite senses in space, so
there is no reaction on the casing. The torques change their sign as tanh(omega/omega_0), see `mbd.parts.losses`.

References
----------
Niemann & Winter (2003), Maschinenelemente II, 21.10.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from mbd.elements.element import Element, rule
from mbd.forces.flank import flank_name
from mbd.forces.sliding import mesh_sliding_rows
from mbd.parts.linear_reference import Assembly

ETA, RADIUS, RATIO, ROLL, SMOOTH = range(5)


@rule(__file__)
def efficiency_rule(values, motion, answer):
    """Torque on kappa = phi1 + phi2; reads the drive and the coast flank."""
    eta, ratio = values[ETA], values[RATIO]
    total = motion.v[0] + values[ROLL] * motion.speed
    s = math.tanh(total / values[SMOOTH])
    ds = (1.0 - s * s) / values[SMOOTH]
    forth, back = (1.0 - eta) / (eta + ratio), (1.0 - eta) / (1.0 + eta * ratio)
    for side in range(2):
        force, row = motion.read_force[2 * side], 2 * side
        sign = 1.0 if side == 0 else -1.0
        way = sign * s
        x = 0.5 * ((1.0 + way) * forth + (1.0 - way) * back)
        dx = 0.5 * (forth - back) * sign * ds
        share = values[RADIUS] * x * s
        answer.lost[0] += share * force
        answer.lost_by_v[0, 0] += values[RADIUS] * force * (x * ds + dx * s)
        answer.lost_by_u[0, 1 + row] = share * motion.read_stiffness[row, 0]
        answer.lost_by_u[0, 2 + row] = share * motion.read_stiffness[row, 1]


def elements(assembly: Assembly) -> Iterator[Element]:
    """One element for each mesh, if the loss model has an efficiency."""
    efficiency, ratios = assembly.machine.losses.mesh_efficiency, assembly.layout.ratios
    if efficiency is None:
        return
    for mesh in assembly.machine.meshes:
        roll = ratios[mesh.driving] + ratios[mesh.driven]
        yield Element(
            kind="efficiency",
            name=f"{mesh.name} losses",
            part=f"{mesh.name} losses",
            rule=efficiency_rule,
            values=(
                efficiency, mesh.base_radius_driving, mesh.ratio, roll, assembly.smoothing * roll
            ),
            rows=mesh_sliding_rows(assembly.layout, mesh, 1)[1:],
            row_names=("kappa",),
            scale=(assembly.mesh_loads[mesh.name] * mesh.base_radius_driving,),
            reads=(flank_name(mesh.name, 0), flank_name(mesh.name, 1)),
            rolls=True,
        )  # fmt: skip
