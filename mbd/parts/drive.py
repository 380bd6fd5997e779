"""Drive: motors that follow a prescribed speed, each through a coupling that holds only the rotation.

Torque on the shaft in the lifting sense: k (phi_m - phi) + c (phi_m' - phi'). All motors follow one profile.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbd.parts.checks import MachineError, finite, frozen_array, not_negative, positive


@dataclass(frozen=True, kw_only=True)
class CouplingSpec:
    """A motor coupling at ``y`` of ``shaft`` (N m/rad, N m s/rad); ``name`` is the motor's, e.g. ``motor_1``."""

    name: str
    shaft: str
    y: float
    stiffness: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        finite(f"coupling {self.name} y", self.y)
        positive(f"coupling {self.name} stiffness", self.stiffness)
        not_negative(f"coupling {self.name} damping", self.damping)


@dataclass(frozen=True, eq=False, kw_only=True)
class SpeedProfile:
    """Motor speed (rad/s, lifting positive), linear between the given times (s) and constant outside."""

    times: np.ndarray
    speeds: np.ndarray

    def __post_init__(self) -> None:
        times, speeds = frozen_array(self.times), frozen_array(self.speeds)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "speeds", speeds)
        if len(times) != len(speeds) or len(times) == 0:
            raise MachineError(f"speed profile: {len(times)} times for {len(speeds)} speeds; give pairs.")
        if not (np.isfinite(times).all() and np.isfinite(speeds).all()):
            raise MachineError("speed profile: times and speeds must be finite.")
        if (np.diff(times) <= 0).any():
            i = int(np.argmax(np.diff(times) <= 0))
            raise MachineError(
                f"speed profile: time {times[i + 1]} s follows {times[i]} s; times must increase strictly. "
                "Spread a jump over at least one sample."
            )

    @property
    def highest(self) -> float:
        """Largest |speed|, rad/s."""
        return float(abs(self.speeds).max())

    def speed(self, time: np.ndarray) -> np.ndarray:
        """phi_m' at ``time``, rad/s."""
        return np.interp(time, self.times, self.speeds)

    def angle(self, time: np.ndarray) -> np.ndarray:
        """phi_m at ``time``, rad; 0 at t = 0, the exact integral of the speed."""
        return self._integral(np.asarray(time, dtype=float)) - self._integral(np.zeros(1))[0]

    def motion(self, first: int, steps: int, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Angle and speed (step,) at the ends of steps from number ``first`` on, and the mean acceleration in each."""
        times = step * np.arange(first, first + steps + 1)
        speeds = self.speed(times)
        return self.angle(times[1:]), speeds[1:], np.diff(speeds) / step

    def _integral(self, time: np.ndarray) -> np.ndarray:
        t, v = self.times, self.speeds
        corner = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
        i = np.clip(np.searchsorted(t, time, side="right") - 1, 0, len(t) - 1)
        dt = time - t[i]
        last = i == len(t) - 1
        nxt = np.minimum(i + 1, len(t) - 1)
        slope = np.where(last | (dt < 0), 0.0, (v[nxt] - v[i]) / np.where(last, 1.0, t[nxt] - t[i]))
        return corner[i] + v[i] * dt + 0.5 * slope * dt * dt
