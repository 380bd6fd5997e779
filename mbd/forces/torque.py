"""Torque over time or over speed on a shaft or rotor: drives, brakes, fans and pumps known by their characteristic."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from mbd.elements.element import Rule, rule
from mbd.elements.lookup_tables import interpolated
from mbd.forces.torque_source import TorqueSource
from mbd.parts.part_checks import freeze_pairs


@rule(__file__)
def torque_rule(values, motion, answer):
    """Torque on a rotation, linear between times and constant outside; ``values`` are the times, then the torques."""
    answer.lost[0] = -interpolated(values, 0, len(values) // 2, motion.time)[0]


@rule(__file__)
def speed_torque_rule(values, motion, answer):
    """Torque on a rotation, linear between speeds and constant outside; ratio, speeds, torques."""
    speed = motion.v[0] + values[0] * motion.speed
    torque, slope = interpolated(values, 1, (len(values) - 1) // 2, speed)
    answer.lost[0], answer.lost_by_v[0, 0] = -torque, -slope


@dataclass(frozen=True, eq=False, kw_only=True)
class TorqueCurve(TorqueSource):
    """Torque (N m, driving positive), linear between places and constant outside; `places_are` names their field."""

    places_are: ClassVar[str]
    torques: np.ndarray

    def __post_init__(self) -> None:
        super().__post_init__()
        freeze_pairs(self, self.name, self.places_are, "torques")

    @property
    def largest(self) -> float:
        """N m."""
        return float(self.torques[int(np.argmax(abs(self.torques)))])


@dataclass(frozen=True, eq=False, kw_only=True)
class Torque(TorqueCurve):
    """Torque over time (s)."""

    rule: ClassVar[Rule] = torque_rule
    places_are: ClassVar[str] = "times"
    times: np.ndarray

    def values(self, ratio: float) -> np.ndarray:
        """Times, then torques."""
        return np.concatenate([self.times, self.torques])

    def at_start(self, speed: float) -> float:
        """N m at t = 0."""
        return float(np.interp(0.0, self.times, self.torques))


@dataclass(frozen=True, eq=False, kw_only=True)
class SpeedTorque(TorqueCurve):
    """Torque over the speed (rad/s) of its shaft or rotor."""

    rule: ClassVar[Rule] = speed_torque_rule
    places_are: ClassVar[str] = "speeds"
    speeds: np.ndarray

    def values(self, ratio: float) -> np.ndarray:
        """The ratio, the speeds, the torques."""
        return np.concatenate([[ratio], self.speeds, self.torques])

    def at_start(self, speed: float) -> float:
        """N m at a speed (rad/s)."""
        return float(np.interp(speed, self.speeds, self.torques))
