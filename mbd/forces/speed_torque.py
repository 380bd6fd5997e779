"""Torque over speed: brakes, fans, pumps, and motors known by their characteristic."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbd.elements.element import Rule, rule
from mbd.elements.lookup import interpolated
from mbd.forces.torque_source import TorqueSource
from mbd.parts.checks import frozen_array, rising_pairs


@rule(__file__)
def speed_torque_rule(values, motion, answer):
    """Torque on a rotation, linear between speeds and constant outside; ratio, speeds, torques."""
    speed = motion.v[0] + values[0] * motion.speed
    torque, slope = interpolated(values, 1, (len(values) - 1) // 2, speed)
    answer.lost[0], answer.lost_by_v[0, 0] = -torque, -slope


@dataclass(frozen=True, eq=False, kw_only=True)
class SpeedTorque(TorqueSource):
    """Torque (N m, driving positive) over the speed (rad/s) of its shaft or rotor, linear between the speeds and
    constant outside."""

    speeds: np.ndarray
    torques: np.ndarray

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "speeds", frozen_array(self.speeds))
        object.__setattr__(self, "torques", frozen_array(self.torques))
        rising_pairs(self.name, ("speeds", self.speeds), ("torques", self.torques))

    @property
    def rule(self) -> Rule:
        """Interpolation over the speed."""
        return speed_torque_rule

    def values(self, ratio: float) -> np.ndarray:
        """The ratio, the speeds, the torques."""
        return np.concatenate([[ratio], self.speeds, self.torques])

    @property
    def largest(self) -> float:
        """N m."""
        return float(self.torques[int(np.argmax(abs(self.torques)))])

    def at_start(self, speed: float) -> float:
        """N m at a speed (rad/s)."""
        return float(np.interp(speed, self.speeds, self.torques))
