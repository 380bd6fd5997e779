"""Outside torque on a shaft over time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mbd.elements.element import Element, rule
from mbd.parts.checks import MachineError, finite, frozen_array
from mbd.parts.load import OutsideForce

if TYPE_CHECKING:
    from mbd.elements.coordinates import Coordinates


@rule(__file__)
def torque_rule(values, motion, answer):
    """Torque on a rotation, linear between times and constant outside; ``values`` are the times, then the torques."""
    n = len(values) // 2
    torque = values[n]
    for i in range(n - 1):
        if motion.time > values[i]:
            share = min((motion.time - values[i]) / (values[i + 1] - values[i]), 1.0)
            torque = (1.0 - share) * values[n + i] + share * values[n + i + 1]
    answer.lost[0] = -torque


@dataclass(frozen=True, eq=False, kw_only=True)
class Torque(OutsideForce):
    """Torque (N m, driving in the lifting sense) over time (s) at ``y`` of ``shaft``; linear between the times."""

    times: np.ndarray
    torques: np.ndarray

    def __post_init__(self) -> None:
        finite(f"{self.name} y", self.y)
        object.__setattr__(self, "times", frozen_array(self.times))
        object.__setattr__(self, "torques", frozen_array(self.torques))
        if len(self.times) != len(self.torques) or len(self.times) == 0:
            raise MachineError(f"{self.name}: {len(self.times)} times for {len(self.torques)} torques; give pairs.")
        if not (np.isfinite(self.times).all() and np.isfinite(self.torques).all()):
            raise MachineError(f"{self.name}: times and torques must be finite.")
        if (np.diff(self.times) <= 0).any():
            raise MachineError(
                f"{self.name}: its times must increase strictly. Spread a jump over at least one sample."
            )

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """The torque on the rotation of its shaft."""
        yield Element(
            kind="torque",
            name=self.name,
            part=self.name,
            rule=torque_rule,
            values=np.concatenate([self.times, self.torques]),
            rows=lay.angle_row(self.shaft, self.y)[None],
            row_names=("angle",),
            scale=(max(float(abs(self.torques).max()), 1e-6),),
            rolls=True,
        )
