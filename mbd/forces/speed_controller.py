"""Motor under a speed controller with proportional and integral part and a torque limit.

    T = clip(T_u, -T_max, T_max),   T_u = k_p (omega_ref - omega) + k_i (phi_ref - phi - w) + T_0

The integral of the speed error is the error of the angle; T_0 is the torque of the integral part at t = 0. While the
torque is limited the integral would continue to grow (windup), and the speed would overshoot until the opposite error
has reduced it. Back-calculation returns the excess of the torque to the integral with the tracking time T_t:

    w' = (T_u - T)/(k_i T_t),   T_t = k_p/k_i, the time of the integral.

So w, an angle by which the reference shifts, is constant unless the torque is limited. It is a coordinate with a
damper, driven by e (T_u - T) with an e so small that it takes no energy. A coordinate also needs a mass and a spring:
the mass delays w by T_t/1000, the spring returns it within days.

References
----------
Fertik & Ross (1967), ISA Transactions 6(4), 317-328; Astrom & Hagglund (1995), PID Controllers, section 3.5
(back-calculation, and the choice of T_t).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np

from fem.options import option
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import Element, Rule, Signal, rule
from mbd.elements.linear_part import Matrices, Part, part_on_rows
from mbd.elements.lookup_tables import cell_below, interpolated
from mbd.elements.mode_words import ModeWords
from mbd.forces.torque_source import TorqueSource
from mbd.parts.speed_drive import SpeedProfile

WORDS = ModeWords("controller", "controllers")
SHARE = 1e-6  # e: share of the torque that drives w
DELAY = 1e-3  # of w, in tracking times
HOLD = 2 * math.pi * 0.05  # rad/s, of the mass of w on its spring: above the limit of free motions
RATIO, PROPORTIONAL, INTEGRAL, LIMIT, START, FIRST = range(6)  # then times, speeds, angles (n,) of the reference


@rule(__file__)
def controller_rule(values, motion, answer):
    """Torque on a rotation by the errors of speed and angle; force that moves w on the second row, if there is one.

    Until t = 0 w is constant: at the start the integral part has its given torque, whatever T_u is.
    """
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
    gives_way = len(motion.u) > 1
    if gives_way:
        torque -= ki * motion.u[1]
    if abs(torque) < values[LIMIT]:
        answer.lost[0] = -torque
        answer.lost_by_u[0, 0], answer.lost_by_v[0, 0] = ki, kp
        if gives_way:
            answer.lost_by_u[0, 1] = ki
        return
    limited = values[LIMIT] if torque > 0.0 else -values[LIMIT]
    answer.lost[0] = -limited
    if gives_way and time > 0.0:
        answer.lost[1] = SHARE * (limited - torque)
        answer.lost_by_u[1, 0], answer.lost_by_u[1, 1], answer.lost_by_v[1, 0] = SHARE * ki, SHARE * ki, SHARE * kp


@dataclass(frozen=True, eq=False, kw_only=True)
class SpeedController(TorqueSource):
    """A motor under PI speed control."""

    rule: ClassVar[Rule] = controller_rule
    model: Literal["controlled-motor"] = "controlled-motor"
    times: np.ndarray = option(unit="s", text="times, ascending from 0")
    speeds: np.ndarray = option(unit="rpm", text="target speed at these times")
    proportional: float = option(unit="N m s/rad", gt=0, text="proportional gain: torque per speed error")
    integral: float = option(0.0, unit="N m/rad", ge=0, text="integral gain: torque per angle error")
    limit: float = option(unit="N m", gt=0, text="largest torque in both directions")
    starting_torque: float = option(0.0, unit="N m", text="torque of the integral part at t = 0")
    anti_windup: bool = option(
        True, text="true: back-calculation reduces the integral part while the torque is limited"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("times", "speeds"):
            object.__setattr__(self, name, getattr(self.reference, name))

    @property
    def reference(self) -> SpeedProfile:
        """Target speed of its shaft or rotor."""
        return SpeedProfile(times=self.times, speeds=self.speeds)

    @property
    def _given_way(self) -> tuple[str, ...]:
        """Name of the coordinate w, with back-calculation."""
        return (f"{self.name}:given_way",) if self.anti_windup and self.integral > 0.0 else ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The angle of a rotor behind a coupling, and w."""
        return (*super().coordinates, *self._given_way)

    def rolling(self, ratios: Mapping[str, float]) -> np.ndarray:
        """The rotor turns with its shaft, w does not."""
        turning = len(self.coordinates) - len(self._given_way)
        return np.array([ratios[self.shaft]] * turning + [0.0] * len(self._given_way))

    def parts(self, lay: Coordinates) -> Iterator[Part]:
        """Inertia and coupling; mass, damper and spring of w."""
        yield from super().parts(lay)
        for coordinate in self._given_way:
            damper = SHARE * self.proportional
            mass = DELAY * self.proportional / self.integral * damper
            yield part_on_rows(
                lay.own_row(coordinate)[None],
                name=f"{self.name} anti-windup",
                words=WORDS,
                matrices=Matrices(
                    mass=np.array([[mass]]), stiffness=np.array([[HOLD**2 * mass]]), damping=np.array([[damper]])
                ),
            )

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """Torque, and the force that moves w."""
        for torque in super().elements(lay):
            for coordinate in self._given_way:
                torque = replace(
                    torque,
                    rows=np.vstack([torque.rows, lay.own_row(coordinate)]),
                    row_names=(*torque.row_names, "given way"),
                    scale=(*torque.scale, SHARE * torque.scale[0]),
                    signals=tuple(Signal(s.name, s.units, force=(*s.force, 0.0)) for s in torque.signals),
                )
            yield torque

    def values(self, ratio: float) -> np.ndarray:
        """Gains, then the reference from t = 0 on."""
        times = self.reference.times
        times = np.concatenate([[0.0], times[times > 0.0]])
        speeds, angles = self.reference.speed(times), self.reference.angle(times)
        gains = [ratio, self.proportional, self.integral, self.limit, self.starting_torque]
        return np.concatenate([gains, times, speeds, angles])

    @property
    def highest_speed(self) -> float:
        """Highest speed of the reference, rad/s."""
        return self.reference.highest

    @property
    def largest(self) -> float:
        """Torque limit, N m."""
        return self.limit

    def at_start(self, speed: float) -> float:
        """Torque (N m) at t = 0 for a speed (rad/s)."""
        error = float(self.reference.speed(np.zeros(1))[0]) - speed
        return float(np.clip(self.proportional * error + self.starting_torque, -self.limit, self.limit))
