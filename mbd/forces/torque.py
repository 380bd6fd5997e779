"""Torque over time on a shaft or rotor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbd.elements.element import Rule, rule
from mbd.elements.lookup import interpolated
from mbd.forces.torque_source import TorqueSource
from mbd.parts.checks import frozen_array, rising_pairs


@rule(__file__)
def torque_rule(values, motion, answer):
    """Torque on a rotation, linear between times and constant outside; ``values`` are the times, then the torques."""
    answer.lost[0] = -interpolated(values, 0, len(values) // 2, motion.time)[0]


@dataclass(frozen=True, eq=False, kw_only=True)
class Torque(TorqueSource):
    """Torque (N m, driving positive) over time (s), linear between the times and constant outside."""

    times: np.ndarray
    torques: np.ndarray

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "times", frozen_array(self.times))
        object.__setattr__(self, "torques", frozen_array(self.torques))
        rising_pairs(self.name, ("times", self.times), ("torques", self.torques))

    @property
    def rule(self) -> Rule:
        """Interpolation over the time."""
        return torque_rule

    def values(self, ratio: float) -> np.ndarray:
        """Times, then torques."""
        return np.concatenate([self.times, self.torques])

    @property
    def largest(self) -> float:
        """N m."""
        return float(self.torques[int(np.argmax(abs(self.torques)))])

    def at_start(self, speed: float) -> float:
        """N m at t = 0."""
        return float(np.interp(0.0, self.times, self.torques))
