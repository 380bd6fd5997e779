"""Drag of the bearings under their load, and the holding brake: torques that oppose the rotation.

The drag torque of a bearing is mu_b P d/2 with its load P at rest and the diameter d of the shaft; the reaction on the
casing is neglected. The brake is closed while the motors are at rest: its torque decreases with the motor speed as
(1 - (speed/omega_0)^2)^2. Both torques change their sign as tanh(omega/omega_0), see `mbd.parts.losses`.

References
----------
SKF (2018), Rolling Bearings, p. 132 (M = 0.5 mu P d).
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from mbd.elements.element import Element, rule
from mbd.parts.linear_reference import Assembly

TORQUE, ROLL, SMOOTH, CLOSING = range(4)  # closing: motor speed below which a brake acts, 0 for a drag


@rule(__file__)
def drag_rule(values, motion, answer):
    """Torque on a rotation."""
    torque, closing = values[TORQUE], values[CLOSING]
    if closing > 0.0:
        rest = 1.0 - (motion.speed / closing) ** 2
        if rest <= 0.0:
            return
        torque *= rest * rest
    s = math.tanh((motion.v[0] + values[ROLL] * motion.speed) / values[SMOOTH])
    answer.lost[0] = torque * s
    answer.lost_by_v[0, 0] = torque * (1.0 - s * s) / values[SMOOTH]


def bearing_drags(assembly: Assembly) -> Iterator[Element]:
    """One element for each bearing, if the loss model has bearing drag."""
    friction = assembly.machine.losses.bearing_friction
    if friction == 0.0:
        return
    at_rest = assembly.resting_displacement
    for bearing in assembly.machine.bearings:
        section = assembly.machine.shaft(bearing.shaft).section_at(bearing.y)
        torque = friction * bearing.resting_force(assembly.layout, at_rest) * section.outer_diameter / 2
        yield _drag(assembly, f"{bearing.name} drag", bearing.shaft, bearing.y, torque, max(torque, 1e-6), 0.0)


def brakes(assembly: Assembly) -> Iterator[Element]:
    """The holding brake, if there is one."""
    brake = assembly.machine.brake
    if brake is not None and brake.torque > 0.0:
        yield _drag(assembly, "brake", brake.shaft, brake.y, brake.torque, brake.torque, assembly.smoothing)


def _drag(
    assembly: Assembly, name: str, shaft: str, y: float, torque: float, scale: float, closing: float
) -> Element:  # fmt: skip
    roll = assembly.layout.ratios[shaft]
    return Element(
        kind="drag",
        name=name,
        part=name,
        rule=drag_rule,
        values=(torque, roll, assembly.smoothing * roll, closing),
        rows=assembly.layout.angle_row(shaft, y)[None],
        row_names=("angle",),
        scale=(scale,),
        rolls=True,
    )
