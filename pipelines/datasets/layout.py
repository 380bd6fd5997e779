"""What every run of a campaign records: names, dimensions and types of its signals, the same for all runs."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mbd.output.trajectory import Trajectory
from pipelines.io.errors import InputError, WorkError
from pipelines.io.shown import shown
from pipelines.signals.labelled import Signal, coordinates, read, signals

FACTS = "campaign.json"  # what a data set is and how it was made, written when its campaign begins
CASING_SIGNALS = ("acceleration", "shaft_angle", "motor_speed", "motor_torque")
GROUND_SIGNALS = ("journal_acceleration", "shaft_angle", "motor_speed", "motor_torque")


@dataclass(frozen=True, kw_only=True)
class SignalLayout:
    """One signal of a run: `shape` and `dims` end with time; `dtype` is how it is stored."""

    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: str
    attributes: Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class RunLayout:
    """All signals of a run: `samples` at 0, 1/`rate`, ...; `names` along every dimension but time."""

    signals: tuple[SignalLayout, ...]
    names: Mapping[str, tuple[Any, ...]]
    samples: int
    rate: float

    @property
    def bytes(self) -> int:
        """Of one run before it is packed."""
        return sum(int(np.prod(one.shape)) * np.dtype(one.dtype).itemsize for one in self.signals)


def run_layout(motion: Trajectory, samples: int, wanted: Sequence[str] = ()) -> RunLayout:
    """The layout of runs like a motion.

    Parameters
    ----------
    motion : of any length
    samples : of a whole run
    wanted : names of signals; by default the accelerations with shaft angles, speed and torque of the motors

    Raises
    ------
    InputError : a signal that such a motion does not have
    """
    found = {signal.name: signal for signal in signals(motion)}
    if not wanted:
        wanted = CASING_SIGNALS if motion.sensors else GROUND_SIGNALS
    for name in wanted:
        if name not in found:
            raise InputError(f"signals: {name!r} is not a signal of this scene. Allowed: {', '.join(found)}.")
    chosen = [found[name] for name in dict.fromkeys(wanted)]
    used = {dim for signal in chosen for dim in signal.dims}
    return RunLayout(
        signals=tuple(
            SignalLayout(
                name=signal.name,
                dims=(*signal.dims, "time"),
                shape=(*signal.rows.shape, samples),
                dtype=signal.dtype.str,
                attributes=signal.attributes,
            )
            for signal in chosen
        ),
        names={name: tuple(values) for name, values in coordinates(motion).items() if name in used},
        samples=samples,
        rate=motion.output_rate,
    )


def run_arrays(motion: Trajectory, layout: RunLayout) -> dict[str, np.ndarray]:
    """The signals of a run in their layout.

    Raises
    ------
    WorkError : the motion has other signals, names, length or rate than the layout
    """
    found = {signal.name: signal for signal in signals(motion)}
    names = {name: tuple(values) for name, values in coordinates(motion).items()}
    if (len(motion.time), motion.output_rate) != (layout.samples, layout.rate):
        raise WorkError(
            f"this scene has {len(motion.time)} samples at {motion.output_rate:g} Hz, the campaign {layout.samples} at "
            f"{layout.rate:g} Hz. Set simulation.end_s and simulation.output_rate_Hz alike in all scenes."
        )
    for one in layout.signals:
        if one.name not in found:
            raise WorkError(
                f"this scene has no signal {one.name}, which the campaign records. Set `signals` of the plan to those "
                "of all scenes."
            )
    for name, values in layout.names.items():
        if names.get(name) != values:
            raise WorkError(
                f"{name}: this scene has {', '.join(map(str, names.get(name, ('none',))))}, the campaign "
                f"{', '.join(map(str, values))}. Set sensors, probes and shafts alike in all scenes."
            )
    return {one.name: _time_last(motion, found[one.name]) for one in layout.signals}


def _time_last(motion: Trajectory, signal: Signal) -> np.ndarray:
    return np.ascontiguousarray(np.moveaxis(read(motion, signal, slice(None)), 0, -1))


def read_facts(folder: str | Path) -> dict[str, Any]:
    """What campaign.json holds.

    Raises
    ------
    InputError : this is no folder of a campaign
    """
    path = Path(folder) / FACTS
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        told["identity"], told["runs"], told["facts"]["plan"], stored_layout(told["layout"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        reason = f"it has no {FACTS}" if isinstance(error, FileNotFoundError) else shown(str(error))
        raise InputError(
            f"{shown(folder)}: not the folder of a data set ({reason}). Give the folder that `gearcase campaign` wrote."
        ) from error
    return told


def stored_layout(told: dict[str, Any]) -> RunLayout:
    """The layout in campaign.json. KeyError, TypeError if it is none."""
    signals = tuple(
        SignalLayout(
            name=one["name"],
            dims=tuple(one["dims"]),
            shape=tuple(one["shape"]),
            dtype=one["dtype"],
            attributes=one["attributes"],
        )
        for one in told["signals"]
    )
    names = {name: tuple(values) for name, values in told["names"].items()}
    return RunLayout(signals=signals, names=names, samples=told["samples"], rate=told["rate"])
