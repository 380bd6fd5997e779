"""Induction motor by its static torque-speed curve: Kloss' formula.

    T(s) = 2 T_b (1 + s_b/beta) / (s/s_b + s_b/s + 2 s_b/beta),  s = (omega_s - omega)/omega_s

with 1/beta = 0 (stator resistance neglected): T = 2 T_b / (s/s_b + s_b/s), where T_b is the breakdown torque at the
slip s_b. The curve is odd in s: above the synchronous speed omega_s the machine brakes. Electrical transients are
neglected, which is valid if the torque changes slowly compared with the period of the supply.

References
----------
Kloss (1909); Fitzgerald, Kingsley & Umans (2003), Electric Machinery, section 6.5.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from fem.options import in_si, option
from mbd.elements.element import Rule, rule
from mbd.forces.torque_source import TorqueSource
from mbd.parts.part_checks import MachineError

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
    """An induction motor on the mains, with the formula of Kloss."""

    rule: ClassVar[Rule] = induction_rule
    model: Literal["induction-motor"] = "induction-motor"
    synchronous_speed: float = option(
        unit="rpm",
        key="synchronous_rpm",
        gt=0,
        text="synchronous speed: 60 times mains frequency divided by pole pairs",
    )
    rated_speed: float = option(unit="rpm", key="rated_rpm", gt=0, text="speed at the rated torque")
    rated_torque: float = option(unit="N m", gt=0, text="torque at the rated speed")
    breakdown_ratio: float = option(2.5, gt=1, le=10, text="breakdown torque divided by rated torque")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rated_speed >= self.synchronous_speed:
            rpm = in_si(1.0, "rpm")
            raise MachineError(
                f"rated_rpm = {self.rated_speed / rpm:g} must be below synchronous_rpm = "
                f"{self.synchronous_speed / rpm:g}, because the torque grows with the slip. Correct them"
            )
        if self.breakdown_slip >= 1.0:
            raise MachineError(f"breakdown_slip {self.breakdown_slip!r} must lie between 0 and 1.")

    @property
    def breakdown_torque(self) -> float:
        """T_b, N m."""
        return self.breakdown_ratio * self.rated_torque

    @property
    def breakdown_slip(self) -> float:
        """s_b = s_N (k + sqrt(k^2 - 1)) with the breakdown torque k times that at the rated slip s_N."""
        rated_slip = 1.0 - self.rated_speed / self.synchronous_speed
        return rated_slip * (self.breakdown_ratio + float(np.sqrt(self.breakdown_ratio**2 - 1.0)))

    def values(self, ratio: float) -> np.ndarray:
        """Numbers of the rule."""
        return np.array([ratio, self.synchronous_speed, self.breakdown_torque, self.breakdown_slip])

    @property
    def highest_speed(self) -> float:
        """The synchronous speed, rad/s."""
        return self.synchronous_speed

    @property
    def largest(self) -> float:
        """The breakdown torque, N m."""
        return self.breakdown_torque

    def at_start(self, speed: float) -> float:
        """N m at a speed (rad/s)."""
        x = (1.0 - speed / self.synchronous_speed) / self.breakdown_slip
        return 2.0 * self.breakdown_torque * x / (1.0 + x * x)
