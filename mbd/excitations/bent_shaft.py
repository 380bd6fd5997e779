"""A bent shaft: a fixed bow that turns with it.

A shaft that would rest at the bow b(y) stores (q - b)^T K (q - b)/2, so that the force K b acts on it, which turns.
The bow has the shape of the shaft under a force at ``y`` between two places where it is straight, as of a shaft bent in
a press: K b is then that force and its two reactions,

    U = k b^2/2 - k b n . d,   d = u(y) - (1 - share) u(y_1) - share u(y_2),

with n of `mbd.excitations.turned_direction`, the deflection d over the chord, and the stiffness k of the shaft simply
supported at y_1 and y_2 under a force at y. The torque on the rotation follows from the same potential.

References
----------
Nicholas, Gunter & Allaire (1976), J. Eng. Power 98(2), 171-181 and 182-189 (residual bow of a Jeffcott rotor).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.options import option
from mbd.elements.component import Place
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import ENERGY, Element, rule
from mbd.excitations.turned_direction import turned_direction
from mbd.parts.checks import MachineError
from mbd.parts.load import TurningForce

APART = 1e-6  # m: places closer than that are the same
START, SENSE, ROLL, FORCE, BOW = range(5)


@rule(__file__)
def bow_rule(values, motion, answer):
    """On the angle and the deflections in x and z; the force is k b."""
    s, force, u = values[SENSE], values[FORCE], motion.u
    cos, sin = turned_direction(values[START], s, values[ROLL], motion.angle, u[0])
    answer.elastic[0] = s * force * (u[2] * cos - u[1] * sin)
    answer.elastic[1], answer.elastic[2] = -force * cos, -force * sin
    stiffness = answer.stiffness
    stiffness[0, 0] = force * (u[1] * cos + u[2] * sin)
    stiffness[0, 1] = stiffness[1, 0] = -s * force * sin
    stiffness[0, 2] = stiffness[2, 0] = s * force * cos
    answer.log[ENERGY] = force * (0.5 * values[BOW] - u[1] * cos - u[2] * sin)


@dataclass(frozen=True, eq=False, kw_only=True)
class BentShaft(TurningForce):
    """A bent shaft, bowed as by a force at position_mm between two places that stay straight."""

    model: Literal["bent-shaft"] = "bent-shaft"
    bow: float = option(unit="um", gt=0, text="distance of the bent axis from the straight one at position_mm")
    straight: tuple[float, float] = option(
        unit="mm", key="straight_at_mm", text="y of two places without bow, usually the bearings"
    )
    angle: float = option(0.0, unit="deg", text="angle of the bow at t = 0, from +x towards +z")

    def __post_init__(self) -> None:
        super().__post_init__()
        if abs(self.straight[1] - self.straight[0]) < APART or min(abs(y - self.y) for y in self.straight) < APART:
            raise MachineError(
                f"straight_at_mm = {[float(f'{1000 * y:.12g}') for y in self.straight]} must be two places other than "
                f"position_mm = {1000 * self.y:g}. Set them, usually to the bearings"
            )

    @property
    def places(self) -> tuple[Place, ...]:
        """The bow and where it is straight."""
        return tuple(Place(self.name, self.shaft, y) for y in (self.y, *self.straight))

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """The force that bends it."""
        first, second = self.straight
        share = (self.y - first) / (second - first)
        shares = ((self.y, 1.0), (first, share - 1.0), (second, -share))
        force = self.bow / lay.flexibility(self.shaft, self.y, self.straight)
        yield Element(
            kind="bent shaft",
            name=self.name,
            part=self.name,
            rule=bow_rule,
            values=(*self.direction(lay, self.angle), force, self.bow),
            rows=np.array(
                [
                    lay.angle_row(self.shaft, self.y),
                    *(sum(part * lay.axis_row(self.shaft, y, axis) for y, part in shares) for axis in (0, 2)),
                ]
            ),
            row_names=("angle", "ux", "uz"),
            scale=(force * self.bow, force, force),
            rolls=True,
        )
