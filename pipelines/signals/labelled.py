"""Signals: the channels of a motion under the names and dimensions that users see, and how each one is stored."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbd.output.trajectory import Trajectory
from mbd.parts import channels
from pipelines.signals.motion_warnings import ATTRIBUTE, motion_warnings

AXES = list(channels.DIRECTIONS)
_NAMED = {  # what a motion names itself, by dimension
    "motor": "motors",
    "source": "sources",
    "shaft": "shafts",
    "stage": "meshes",
    "bearing": "bearings",
    "sensor": "sensors",
}
ROUNDED = ("m/s2", "N", "N m")
ROUNDING = "float32, rounded by at most 2^-24 (6e-8) of each value; the motion in the cache is float64"


@dataclass(frozen=True, eq=False, kw_only=True)
class Signal:
    """One variable of a response: `rows` are numbers of channels, in the shape of `dims` (time comes before them)."""

    name: str
    dims: tuple[str, ...]
    rows: np.ndarray
    units: str
    text: str

    @property
    def dtype(self) -> np.dtype:
        """How it is stored."""
        return stored_type(self.units)

    @property
    def attributes(self) -> dict[str, str]:
        """Units, words, and the rounding where there is one."""
        rounding = {"storage": ROUNDING} if self.units in ROUNDED else {}
        return {"units": self.units, "long_name": self.text, **rounding}


def stored_type(units: str) -> np.dtype:
    """How a signal is stored: accelerations, forces and torques as float32, all else as float64.

    A float32 is rounded by at most 2^-24 (6e-8) of its own value. So the error is less than 1e-7 of the signal's rms,
    and up to peaks of 160 m/s2 a thousand times smaller than a sensor noise of 0.01 m/s2. Angles, speeds and positions
    are differenced and differentiated: there a small vibration rides on a large value.
    """
    return np.dtype("<f4" if units in ROUNDED else "<f8")


def signals(motion: Trajectory) -> Iterator[Signal]:
    """All signals of a motion."""
    number = {name: row for row, name in enumerate(motion.channel_names)}
    for kind in channels.channel_kinds():
        named = [kind.spelled(thing) for thing in _things(kind, motion)] if kind.dims else [(kind.quantity,)]
        if named and named[0][0] in number:
            rows = np.array([[number[name] for name in names] for names in named])
            shape = rows.shape[: len(kind.dims)]
            yield Signal(
                name=kind.variable,
                dims=kind.dims,
                rows=rows.reshape(shape),
                units=motion.channel_units[rows.flat[0]],
                text=kind.text,
            )


def _things(kind: channels.ChannelKind, motion: Trajectory) -> tuple[str, ...]:
    """What a kind of channel is recorded of."""
    if (dimension := kind.dims[0]) in _NAMED:
        found: tuple[str, ...] = getattr(motion, _NAMED[dimension])
        return found
    last = kind.spelled("")[0]
    return tuple(name.removesuffix(last) for name in motion.channel_names if name.endswith(last))


def read(motion: Trajectory, signal: Signal, time: int | slice, place: tuple[int | slice, ...] = ()) -> np.ndarray:
    """A part of a signal (time, ...) as it is stored; only its channels and instants are read.

    Parameters
    ----------
    motion, signal : the motion, and one of its signals
    time : instants, from 0
    place : number or slice along each dimension of the signal but time; the last ones may be left out
    """
    rows = signal.rows[place]
    values = np.asarray(motion.values[np.ravel(rows), time]).T.astype(signal.dtype)
    return values.reshape(values.shape[:-1] + np.shape(rows))


def coordinates(motion: Trajectory) -> dict[str, list]:
    """The names along all dimensions but time."""
    named: dict[str, Any] = {}
    for kind in channels.channel_kinds():
        if kind.dims:
            named.setdefault(kind.dims[0], _things(kind, motion))
        if kind.labels and kind.spelled((*_things(kind, motion), "")[0])[0] in motion.channel_names:
            named[kind.dims[-1]] = kind.labels
    named |= {"stage": range(1, len(motion.meshes) + 1), "axis": AXES}
    return {name: list(values) for name, values in named.items() if len(values)}


def facts(motion: Trajectory) -> dict[str, Any]:
    """What the motion says of itself, as attributes."""
    balance = {
        part: dict(zip(motion.energy_entries, map(float, row), strict=True))
        for part, row in zip(motion.energy_parts, motion.energies, strict=True)
    }
    return {
        "integrator": motion.integrator,
        "step_s": motion.step,
        "step_error": motion.step_error,
        "repeatable_until_s": motion.parted_at or "the end",
        "pass_band_Hz": motion.pass_band,
        "counters": json.dumps(dict(zip(motion.counter_names, map(int, motion.counters), strict=True))),
        "energy_balance_J": json.dumps(balance),
        ATTRIBUTE: json.dumps(motion_warnings(motion)),
    }
