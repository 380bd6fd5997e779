"""Drive: motors that follow a prescribed speed, each through a coupling that holds only the rotation.

Torque on the shaft in the positive sense: k (phi_m - phi) + c (phi_m' - phi'). All motors follow one profile. Drives
that give a torque instead are in `mbd.forces.torque_source`.

References
----------
Fritsch & Butland (1984), SIAM J. Sci. Stat. Comput. 5(2), 300-304 (monotone cubic).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mbd.elements.channel_reading import Reading
from mbd.elements.component import Component, Place
from mbd.elements.linear_part import Matrices, Part, part_on_rows
from mbd.elements.mode_words import ModeWords
from mbd.parts.part_checks import freeze_pairs

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator

    from mbd.elements.coordinates import Coordinates


COUPLING_TORQUE = ":coupling_torque"  # N m, behind the name of a rotor with a coupling


def motor_channels(motor: str) -> tuple[str, str, str]:
    """Names of the channels of a motor: angle (rad), speed (rad/s), torque on the shaft (N m, lifting positive)."""
    return f"{motor}:angle", f"{motor}:speed", f"{motor}:torque"


@dataclass(frozen=True, kw_only=True)
class MotorCoupling:
    """A motor coupling at ``y`` of ``shaft`` (N m/rad, N m s/rad); ``name`` is the motor's, e.g. ``motor_1``."""

    name: str
    shaft: str
    y: float
    stiffness: float
    damping: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Drive(Component):
    """All motors with their couplings: one part of the energy balance."""

    couplings: tuple[MotorCoupling, ...]

    @property
    def places(self) -> tuple[Place, ...]:
        """Places of the couplings."""
        return tuple(Place(f"coupling {c.name}", c.shaft, c.y) for c in self.couplings)

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Channels of every motor."""
        return tuple(name for c in self.couplings for name in motor_channels(c.name))

    def parts(self, lay: Coordinates) -> Iterator[Part]:
        """The couplings, whose far ends turn with the motors."""
        yield part_on_rows(
            np.array([lay.angle_row(c.shaft, c.y) for c in self.couplings]),
            name="drive",
            words=ModeWords("drive", "motor coupling", always=True),
            matrices=Matrices(
                stiffness=np.diag([c.stiffness for c in self.couplings]),
                damping=np.diag([c.damping for c in self.couplings]),
            ),
            driven=np.array([lay.ratios[c.shaft] for c in self.couplings]),
        )

    def readings(self, lay: Coordinates) -> dict[str, Reading]:
        """Angle, speed and torque of every motor."""
        found = {}
        for c in self.couplings:
            angle, speed, torque = motor_channels(c.name)
            row, ratio = lay.angle_row(c.shaft, c.y), lay.ratios[c.shaft]
            found[angle] = Reading("rad", rigid=(ratio, 0.0, 0.0))
            found[speed] = Reading("rad/s", rigid=(0.0, ratio, 0.0))
            found[torque] = Reading("N m", displacement=-c.stiffness * row, velocity=-c.damping * row)
        return found


@dataclass(frozen=True, eq=False, kw_only=True)
class SpeedProfile:
    """Speed of the first drive (rad/s), linear between the given times (s) and constant outside.

    With ``smooth`` it is a monotone cubic (Fritsch & Butland 1984), for measured samples: linear interpolation would
    change the acceleration at every sample abruptly, which excites the machine.
    """

    times: np.ndarray
    speeds: np.ndarray
    smooth: bool = False

    def __post_init__(self) -> None:
        freeze_pairs(self, "speed profile", "times", "speeds")

    @property
    def highest(self) -> float:
        """Largest |speed|, rad/s."""
        return float(abs(self.speeds).max())

    def speed(self, time: np.ndarray) -> np.ndarray:
        """phi_m' at ``time``, rad/s."""
        if self._cubic is not None:
            return self._cubic(np.clip(time, self.times[0], self.times[-1]))
        return np.interp(time, self.times, self.speeds)

    def angle(self, time: np.ndarray) -> np.ndarray:
        """phi_m at ``time``, rad; 0 at t = 0, the exact integral of the speed."""
        integral = self._integral if self._cubic is None else self._cubic_integral
        return integral(np.asarray(time, dtype=float)) - integral(np.zeros(1))[0]

    def motion(self, first: int, steps: int, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Angle and speed (step,) at the ends of steps from number ``first`` on, and the mean acceleration in each."""
        times = step * np.arange(first, first + steps + 1)
        speeds = self.speed(times)
        return self.angle(times[1:]), speeds[1:], np.diff(speeds) / step

    @cached_property
    def _cubic(self) -> PchipInterpolator | None:
        if not self.smooth or len(self.times) < 2:
            return None
        from scipy.interpolate import PchipInterpolator  # expensive to import, and only measured speeds need it

        return PchipInterpolator(self.times, self.speeds)

    def _cubic_integral(self, time: np.ndarray) -> np.ndarray:
        assert self._cubic is not None
        inside = np.clip(time, self.times[0], self.times[-1])
        return self._cubic.antiderivative()(inside) + (time - inside) * self.speed(inside)

    def _integral(self, time: np.ndarray) -> np.ndarray:
        t, v = self.times, self.speeds
        corner = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
        i = np.clip(np.searchsorted(t, time, side="right") - 1, 0, len(t) - 1)
        dt = time - t[i]
        last = i == len(t) - 1
        nxt = np.minimum(i + 1, len(t) - 1)
        slope = np.where(last | (dt < 0), 0.0, (v[nxt] - v[i]) / np.where(last, 1.0, t[nxt] - t[i]))
        return corner[i] + v[i] * dt + 0.5 * slope * dt * dt
