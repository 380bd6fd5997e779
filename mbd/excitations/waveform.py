"""Waveforms: a value over time, as a table or as a swept sine.

The sweep is A e(t) sin(2 pi int f dt), its frequency linear in time from f_0 to f_1. Its envelope e is C1: it rises as
sin^2 over the ``ramp`` at the start and falls likewise at the end, so that what it drives starts and ends at rest.
A table is linear between its times and constant outside.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from fem.numerics.compiled import inner
from mbd.elements.lookup import interpolated
from mbd.parts.checks import MachineError, finite, frozen_array, not_negative, positive, rising_pairs

TABLE, SWEEP = 0.0, 1.0  # the first of the packed numbers


@inner()
def wave_value(packed, time):
    """The value of a waveform, from what its `packed` returns, at a time (s)."""
    if packed[0] == SWEEP:
        return _swept(packed, time)
    return interpolated(packed, 1, (len(packed) - 1) // 2, time)[0]


@inner()
def _swept(packed, time):
    start, end, first, last, ramp, amplitude = packed[1], packed[2], packed[3], packed[4], packed[5], packed[6]
    if time <= start or time >= end:
        return 0.0
    t, length = time - start, end - start
    edge = min(t, length - t)
    rise = math.sin(0.5 * math.pi * min(edge / ramp, 1.0))
    turns = t * (first + 0.5 * (last - first) * t / length)
    return amplitude * rise * rise * math.sin(2.0 * math.pi * turns)


class Waveform(ABC):
    """A value over time."""

    @property
    @abstractmethod
    def packed(self) -> np.ndarray:
        """Numbers for `wave_value`."""

    @property
    @abstractmethod
    def largest(self) -> float:
        """Bound of its absolute value."""

    def values(self, times: np.ndarray) -> np.ndarray:
        """Values (time,) at ``times`` (s)."""
        packed = self.packed
        return np.array([wave_value(packed, float(time)) for time in times])


@dataclass(frozen=True, eq=False, kw_only=True)
class TableWave(Waveform):
    """Values at ``times`` (s); ``name`` is what is told in errors."""

    name: str
    times: np.ndarray
    levels: np.ndarray

    def __post_init__(self) -> None:
        times, levels = frozen_array(self.times), frozen_array(self.levels)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "levels", levels)
        rising_pairs(self.name, ("times", times), ("values", levels))

    @property
    def packed(self) -> np.ndarray:
        """Kind, times, levels."""
        return np.concatenate([[TABLE], self.times, self.levels])

    @property
    def largest(self) -> float:
        """Largest level."""
        return float(abs(self.levels).max())


@dataclass(frozen=True, kw_only=True)
class SweepWave(Waveform):
    """A sine of ``amplitude`` from ``first`` to ``last`` (Hz) between ``start`` and ``end`` (s), faded over ``ramp``
    (s)."""

    name: str
    start: float
    end: float
    first: float
    last: float
    ramp: float
    amplitude: float

    def __post_init__(self) -> None:
        finite(f"{self.name} start", self.start)
        positive(f"{self.name} length", self.end - self.start, "Let it end after its start.")
        not_negative(f"{self.name} first frequency", self.first)
        not_negative(f"{self.name} last frequency", self.last)
        positive(f"{self.name} ramp", self.ramp, "A sweep that starts at once rings all modes.")
        finite(f"{self.name} amplitude", self.amplitude)
        if 2 * self.ramp > self.end - self.start:
            raise MachineError(
                f"{self.name}: two ramps of {self.ramp} s do not fit between {self.start} and {self.end} s; shorten "
                "the ramp or lengthen the sweep."
            )

    @property
    def packed(self) -> np.ndarray:
        """Kind, start, end, frequencies, ramp, amplitude."""
        return np.array([SWEEP, self.start, self.end, self.first, self.last, self.ramp, self.amplitude])

    @property
    def largest(self) -> float:
        """The amplitude."""
        return abs(self.amplitude)
