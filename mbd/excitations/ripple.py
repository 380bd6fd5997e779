"""Torque ripple: a torque on a shaft that goes by its angle, A cos(n phi + alpha).

phi is the true rotation of the shaft (see `mbd.excitations.turning`), n the order: periods per turn, as of the teeth of
a motor or the chambers of a pump. What goes by the angle alone follows from a potential, U = -(A/n) sin(n phi + alpha).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbd.elements.element import ENERGY, Element, rule
from mbd.excitations.turning import TurningForce
from mbd.parts.checks import finite, positive

if TYPE_CHECKING:
    from mbd.elements.coordinates import Coordinates

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
    """``amplitude`` (N m) of the ``order`` of the shaft's rotation, at the phase ``angle`` at t = 0."""

    amplitude: float
    order: float

    def __post_init__(self) -> None:
        finite(f"{self.name} y", self.y)
        positive(f"{self.name} amplitude (N m)", self.amplitude)
        positive(f"{self.name} order", self.order, "The order 0 is a constant torque.")
        finite(f"{self.name} angle", self.angle)

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
