"""Motor under a speed controller with proportional and integral part and a torque limit.

    T = clip(k_p (omega_ref - omega) + k_i int (omega_ref - omega) dt + T_0, -T_max, T_max)

The integral of the speed error is the error of the angle, so that no state besides the motion is needed; T_0 is what
the integral has gathered at t = 0. At the limit the integral goes on: choose speed ramps that the limit can follow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbd.elements.element import rule
from mbd.elements.lookup import cell_below, interpolated
from mbd.parts.checks import finite, not_negative, positive
from mbd.parts.drive import SpeedProfile
from mbd.torques.torque_source import TorqueSource

RATIO, PROPORTIONAL, INTEGRAL, LIMIT, START, FIRST = range(6)  # then times, speeds, angles (n,) of the reference


@rule(__file__)
def controller_rule(values, motion, answer):
    """Torque on a rotation by the errors of speed and angle."""
    n = (len(values) - FIRST) // 3
    time, last = motion.time, FIRST + n - 1
    speed, slope = interpolated(values, FIRST, n, time)
    if time >= values[last]:
        angle = values[last + 2 * n] + speed * (time - values[last])
    else:
        low = FIRST + cell_below(values, FIRST, n, time)
        dt = time - values[low]
        angle = values[low + 2 * n] + (values[low + n] + 0.5 * slope * dt) * dt
    kp, ki, ratio = values[PROPORTIONAL], values[INTEGRAL], values[RATIO]
    torque = kp * (speed - motion.v[0] - ratio * motion.speed)
    torque += ki * (angle - motion.u[0] - ratio * motion.angle) + values[START]
    if abs(torque) >= values[LIMIT]:
        answer.lost[0] = -values[LIMIT] if torque > 0.0 else values[LIMIT]
        return
    answer.lost[0] = -torque
    answer.lost_by_u[0, 0], answer.lost_by_v[0, 0] = ki, kp


@dataclass(frozen=True, eq=False, kw_only=True)
class SpeedController(TorqueSource):
    """``reference`` (speed of its shaft or rotor), ``proportional`` (N m s/rad), ``integral`` (N m/rad), ``limit`` and
    ``starting_torque`` (N m)."""

    reference: SpeedProfile
    proportional: float
    integral: float
    limit: float
    starting_torque: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        positive(f"{self.name} proportional", self.proportional)
        not_negative(f"{self.name} integral", self.integral)
        positive(f"{self.name} limit", self.limit)
        finite(f"{self.name} starting_torque", self.starting_torque)

    @property
    def rule(self) -> int:
        """The controller."""
        return controller_rule

    def values(self, ratio: float) -> np.ndarray:
        """Gains, then the reference from t = 0 on."""
        times = self.reference.times
        times = np.concatenate([[0.0], times[times > 0.0]])
        speeds, angles = self.reference.speed(times), self.reference.angle(times)
        gains = [ratio, self.proportional, self.integral, self.limit, self.starting_torque]
        return np.concatenate([gains, times, speeds, angles])

    @property
    def highest_speed(self) -> float:
        """That of the reference, rad/s."""
        return self.reference.highest

    @property
    def largest(self) -> float:
        """The limit, N m."""
        return self.limit

    def at_start(self, speed: float) -> float:
        """N m at a speed (rad/s)."""
        error = float(self.reference.speed(np.zeros(1))[0]) - speed
        return float(np.clip(self.proportional * error + self.starting_torque, -self.limit, self.limit))
