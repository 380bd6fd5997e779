"""Signals of a motion: its channels under the names and dimensions of a response, with their stored types."""

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
_NAMED = {  # attribute of a motion that holds the names along a dimension
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
class LabelledSignal:
    """One variable of a response; `rows` are its channel numbers in the shape of `dims`, which follow time."""

    name: str
    dims: tuple[str, ...]
    rows: np.ndarray
    units: str
    text: str

    @property
    def dtype(self) -> np.dtype:
        """Data type in the file: float32 for accelerations, forces and torques, float64 for all other signals.

        A float32 is rounded by at most 2^-24 (6e-8) of its value. For accelerations up to 160 m/s2 that is a thousandth
        of a sensor noise of 0.01 m/s2. Angles, speeds and positions need float64, since users subtract and
        differentiate them: they are large values with a small vibration.
        """
        return np.dtype("<f4" if self.units in ROUNDED else "<f8")

    @property
    def attributes(self) -> dict[str, str]:
        """Units, description, and the rounding if it is stored as float32."""
        rounding = {"storage": ROUNDING} if self.units in ROUNDED else {}
        return {"units": self.units, "long_name": self.text, **rounding}


def signals(motion: Trajectory) -> Iterator[LabelledSignal]:
    """All signals of a motion."""
    number = {name: row for row, name in enumerate(motion.channel_names)}
    for kind in channels.channel_kinds():
        named = [kind.spelled(thing) for thing in _things(kind, motion)] if kind.dims else [(kind.quantity,)]
        if named and named[0][0] in number:
            rows = np.array([[number[name] for name in names] for names in named])
            shape = rows.shape[: len(kind.dims)]
            yield LabelledSignal(
                name=kind.variable,
                dims=kind.dims,
                rows=rows.reshape(shape),
                units=motion.channel_units[rows.flat[0]],
                text=kind.text,
            )


def _things(kind: channels.ChannelKind, motion: Trajectory) -> tuple[str, ...]:
    """Names of the parts (shafts, bearings, sensors ...) of which a kind of channel is recorded."""
    if (dimension := kind.dims[0]) in _NAMED:
        found: tuple[str, ...] = getattr(motion, _NAMED[dimension])
        return found
    last = kind.spelled("")[0]
    return tuple(name.removesuffix(last) for name in motion.channel_names if name.endswith(last))


def read(
    motion: Trajectory, signal: LabelledSignal, time: int | slice, place: tuple[int | slice, ...] = ()
) -> np.ndarray:
    """A part of a signal (time, ...) in its stored type; other channels and samples are not read.

    Parameters
    ----------
    motion, signal : the motion, and one of its signals
    time : numbers of samples, from 0
    place : number or slice along each dimension of the signal after time; the last ones may be omitted
    """
    rows = signal.rows[place]
    values = np.asarray(motion.values[np.ravel(rows), time]).T.astype(signal.dtype)
    return values.reshape(values.shape[:-1] + np.shape(rows))


def coordinates(motion: Trajectory) -> dict[str, list]:
    """The names along each dimension except time."""
    named: dict[str, Any] = {}
    for kind in channels.channel_kinds():
        if kind.dims:
            named.setdefault(kind.dims[0], _things(kind, motion))
        if kind.labels and kind.spelled((*_things(kind, motion), "")[0])[0] in motion.channel_names:
            named[kind.dims[-1]] = kind.labels
    named |= {"stage": range(1, len(motion.meshes) + 1), "axis": AXES}
    return {name: list(values) for name, values in named.items() if len(values)}


def facts(motion: Trajectory) -> dict[str, Any]:
    """Attributes of a response: integrator, time step and its error, counters, energy balance and warnings."""
    balance = {
        part: dict(zip(motion.energy_entries, map(float, row), strict=True))
        for part, row in zip(motion.energy_parts, motion.energies, strict=True)
    }
    return {
        "integrator": motion.integrator,
        "step_s": motion.step,
        "step_error": motion.step_error,
        "repeatable_until_s": motion.diverged_at or "the end",
        "pass_band_Hz": motion.pass_band,
        "counters": json.dumps(dict(zip(motion.counter_names, map(int, motion.counters), strict=True))),
        "energy_balance_J": json.dumps(balance),
        ATTRIBUTE: json.dumps(motion_warnings(motion)),
    }
