"""Induction motor by its static torque-speed curve: Kloss' formula.

    T(s) = 2 T_b (1 + s_b/beta) / (s/s_b + s_b/s + 2 s_b/beta),  s = (omega_s - omega)/omega_s

with 1/beta = 0 (stator resistance left out): T = 2 T_b / (s/s_b + s_b/s), T_b the breakdown torque at the slip s_b. The
curve is odd in s: above the synchronous speed omega_s the machine brakes. Its electrical transients are left out, which
is fair while the torque changes more slowly than the supply.

References
----------
Kloss (1909); Fitzgerald, Kingsley & Umans (2003), Electric Machinery, section 6.5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbd.elements.element import Rule, rule
from mbd.forces.torque_source import TorqueSource
from mbd.parts.checks import MachineError, finite, positive

RATIO, SYNCHRONOUS, BREAKDOWN, SLIP = range(4)


@rule(__file__)
def induction_rule(values, motion, answer):
    """Torque on a rotation by the slip."""
    s = (values[SYNCHRONOUS] - motion.v[0] - values[RATIO] * motion.speed) / values[SYNCHRONOUS]
    x = s / values[SLIP]
    torque = 2.0 * values[BREAKDOWN] * x / (1.0 + x * x)
    slope = 2.0 * values[BREAKDOWN] * (1.0 - x * x) / (1.0 + x * x) ** 2  # by x
    answer.lost[0] = -torque
    answer.lost_by_v[0, 0] = slope / (values[SLIP] * values[SYNCHRONOUS])


@dataclass(frozen=True, eq=False, kw_only=True)
class InductionMotor(TorqueSource):
    """``synchronous_speed`` (rad/s, signed by its sense), ``breakdown_torque`` (N m) at the slip
    ``breakdown_slip``."""

    synchronous_speed: float
    breakdown_torque: float
    breakdown_slip: float

    def __post_init__(self) -> None:
        super().__post_init__()
        positive(f"{self.name} breakdown_torque", self.breakdown_torque)
        finite(f"{self.name} synchronous_speed", self.synchronous_speed)
        if self.synchronous_speed == 0.0:
            raise MachineError(f"{self.name}: synchronous_speed must not be 0.")
        if not 0.0 < self.breakdown_slip < 1.0:
            raise MachineError(f"{self.name}: breakdown_slip {self.breakdown_slip!r} must lie between 0 and 1.")

    @property
    def rule(self) -> Rule:
        """Kloss' formula."""
        return induction_rule

    @property
    def _signed(self) -> float:
        return float(np.sign(self.synchronous_speed)) * self.breakdown_torque

    def values(self, ratio: float) -> np.ndarray:
        """Numbers of the rule."""
        return np.array([ratio, self.synchronous_speed, self._signed, self.breakdown_slip])

    @property
    def highest_speed(self) -> float:
        """The synchronous speed, rad/s."""
        return self.synchronous_speed

    @property
    def largest(self) -> float:
        """The breakdown torque, N m."""
        return self._signed

    def at_start(self, speed: float) -> float:
        """N m at a speed (rad/s)."""
        x = (1.0 - speed / self.synchronous_speed) / self.breakdown_slip
        return 2.0 * self._signed * x / (1.0 + x * x)


def breakdown_slip(rated_slip: float, overload: float) -> float:
    """s_b of a motor whose breakdown torque is ``overload`` > 1 times the torque at ``rated_slip``:
    s_b = s_N (overload + sqrt(overload^2 - 1))."""
    return rated_slip * (overload + float(np.sqrt(overload**2 - 1.0)))
