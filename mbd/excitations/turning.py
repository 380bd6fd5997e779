"""Directions that turn with a shaft, in the plane across it.

A direction fixed to the shaft has the angle beta = alpha - s phi from +x towards +z: alpha at t = 0, s the sense of
the shaft, phi = ratio phi_m + its angle row the true rotation, of the train and of the vibration together. Its unit
vector is n = (cos beta, sin beta) in (x, z), and n' = beta' t with t = (-sin beta, cos beta).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

from fem.numerics.compiled import INLINE, inner
from mbd.parts.load import OutsideForce

if TYPE_CHECKING:
    from mbd.elements.coordinates import Coordinates


@inner(**INLINE)
def turned_direction(start, sense, roll, angle, own):
    """(cos beta, sin beta) of a direction that turns with a shaft.

    Parameters
    ----------
    start, sense, roll : alpha (rad), s and the ratio of the shaft's angle to the motor's
    angle, own : of the motor, and the shaft's angle row, rad
    """
    beta = start - sense * (roll * angle + own)
    return math.cos(beta), math.sin(beta)


@dataclass(frozen=True, eq=False, kw_only=True)
class TurningForce(OutsideForce):
    """A force that turns with its shaft; ``angle`` alpha (rad) holds once the shaft has turned by ``rolled`` (rad, in
    its own sense) less."""

    angle: float = 0.0
    rolled: float = 0.0

    def turned(self, turns: Mapping[str, float]) -> Self:
        """The force after its shaft has turned."""
        return replace(self, rolled=self.rolled + turns[self.shaft])

    def direction(self, lay: Coordinates) -> tuple[float, float, float]:
        """The first arguments of `turned_direction`."""
        sense = float(lay.sense(self.shaft))
        return self.angle - sense * self.rolled, sense, lay.ratios[self.shaft]
