"""Waveforms: a value over time, as a table or as a swept sine.

The sweep is A e(t) sin(2 pi int f dt), its frequency linear in time from f_0 to f_1. Its envelope e is C1: it rises as
sin^2 over the ``ramp`` at the start and falls likewise at the end, so that what it drives starts and ends at rest.
A table is linear between its times and constant outside.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.numerics.inner_functions import inner
from fem.options import check_options, option
from mbd.elements.lookup_tables import interpolated
from mbd.parts.part_checks import MachineError, freeze_pairs

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
    """Values over time, linear between the times and constant outside; a subclass gives the unit of its ``levels``."""

    model: Literal["table"] = "table"
    times: np.ndarray = option(unit="s", text="times, strictly ascending")
    levels: np.ndarray

    def __post_init__(self) -> None:
        freeze_pairs(self, type(self).__name__, "times", "levels")

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
    """A swept sine; a subclass gives the unit of its ``amplitude``."""

    model: Literal["sweep"] = "sweep"
    start: float = option(unit="s", ge=0, text="start of the sweep")
    end: float = option(unit="s", gt=0, text="end of the sweep")
    first: float = option(unit="Hz", key="from_Hz", ge=0, text="frequency at the start")
    last: float = option(unit="Hz", key="to_Hz", ge=0, text="frequency at the end")
    ramp: float = option(unit="s", gt=0, text="duration of the rise and of the fall")
    amplitude: float

    def __post_init__(self) -> None:
        check_options(self, MachineError)
        if 2 * self.ramp > self.end - self.start:
            raise MachineError(
                f"ramp_s = {self.ramp:g} is more than half of start_s = {self.start:g} to end_s = {self.end:g}. "
                "Reduce it"
            )

    @property
    def packed(self) -> np.ndarray:
        """Kind, start, end, frequencies, ramp, amplitude."""
        return np.array([SWEEP, self.start, self.end, self.first, self.last, self.ramp, self.amplitude])

    @property
    def largest(self) -> float:
        """The amplitude."""
        return abs(self.amplitude)
