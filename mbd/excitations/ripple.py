"""Torque ripple: a torque on a shaft that depends on its angle, A cos(n phi + alpha).

phi is the true rotation of the shaft (see `mbd.excitations.turned_direction`), n the order: periods per turn, such as
the number of teeth of a motor or of chambers of a pump. The torque has the potential U = -(A/n) sin(n phi + alpha).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from fem.options import option
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import ENERGY, Element, rule
from mbd.parts.checks import positive
from mbd.parts.load import TurningForce

AMPLITUDE, ORDER, PHASE, ROLL = range(4)


@rule(__file__)
def ripple_rule(values, motion, answer):
    """Torque on a rotation; the potential is counted from its lowest."""
    amplitude, order = values[AMPLITUDE], values[ORDER]
    turned = order * (values[ROLL] * motion.angle + motion.u[0]) + values[PHASE]
    answer.elastic[0] = -amplitude * math.cos(turned)
    answer.stiffness[0, 0] = amplitude * order * math.sin(turned)
    answer.log[ENERGY] = amplitude / order * (1.0 - math.sin(turned))


@dataclass(frozen=True, eq=False, kw_only=True)
class TorqueRipple(TurningForce):
    """A torque that varies with the angle of a shaft, at one order of its rotation."""

    model: Literal["torque-ripple"] = "torque-ripple"
    amplitude: float = option(unit="N m", gt=0, text="amplitude of the torque")
    order: float = option(gt=0, text="periods per revolution of the shaft")
    angle: float = option(0.0, unit="deg", key="phase_deg", text="phase of the cosine at t = 0")

    def __post_init__(self) -> None:
        positive(f"{self.name} order", self.order, "The order 0 is a constant torque.")
        super().__post_init__()

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """The torque on the rotation of its shaft."""
        yield Element(
            kind="torque ripple",
            name=self.name,
            part=self.name,
            rule=ripple_rule,
            values=(self.amplitude, self.order, self.angle + self.order * self.rolled, lay.ratios[self.shaft]),
            rows=lay.angle_row(self.shaft, self.y)[None],
            row_names=("angle",),
            scale=(self.amplitude,),
            rolls=True,
        )
