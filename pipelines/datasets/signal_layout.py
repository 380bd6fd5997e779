"""Layout of the signals of a campaign: names, dimensions and types, which are the same for all runs."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mbd.output.trajectory import Trajectory
from pipelines.io.errors import InputError, WorkError
from pipelines.io.shown_text import shown
from pipelines.signals.labelled_signals import coordinates, read, signals

FACTS = "campaign.json"  # identity and layout of a data set, written when its campaign begins
CASING_SIGNALS = ("acceleration", "shaft_angle", "motor_speed", "motor_torque")
GROUND_SIGNALS = ("journal_acceleration", "shaft_angle", "motor_speed", "motor_torque")


@dataclass(frozen=True, kw_only=True)
class SignalLayout:
    """One signal of a run. `shape` and `dims` end with time; `dtype` is the stored type."""

    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: str
    attributes: Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class RunLayout:
    """All signals of a run, with `samples` at 0, 1/`rate`, ... and the `names` along each dimension except time."""

    signals: tuple[SignalLayout, ...]
    names: Mapping[str, tuple[Any, ...]]
    samples: int
    rate: float


def run_layout(motion: Trajectory, samples: int, requested: Sequence[str] = ()) -> RunLayout:
    """The layout of runs whose signals are those of a motion.

    Parameters
    ----------
    motion : of any length
    samples : of a whole run
    requested : names of signals; by default the accelerations, shaft angles, and speed and torque of the motors

    Raises
    ------
    InputError : the motion does not have a requested signal
    """
    found = {signal.name: signal for signal in signals(motion)}
    if not requested:
        requested = CASING_SIGNALS if motion.sensors else GROUND_SIGNALS
    for name in requested:
        if name not in found:
            raise InputError(f"signals: {name!r} is not a signal of this scene. Allowed: {', '.join(found)}.")
    chosen = [found[name] for name in dict.fromkeys(requested)]
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
    """The signals of a run as arrays of the layout.

    Raises
    ------
    WorkError : the motion has other signals, names, length or rate than the layout
    """
    found = {signal.name: signal for signal in signals(motion)}
    names = {name: tuple(values) for name, values in coordinates(motion).items()}
    if (len(motion.time), motion.output_rate) != (layout.samples, layout.rate):
        raise WorkError(
            f"this scene has {len(motion.time)} samples at {motion.output_rate:g} Hz, the campaign {layout.samples} at "
            f"{layout.rate:g} Hz. Set the same simulation.end_s and simulation.output_rate_Hz in all scenes."
        )
    for one in layout.signals:
        if one.name not in found:
            raise WorkError(
                f"this scene has no signal {one.name}, which the campaign records. Set `signals` of the plan to "
                "signals that all scenes have."
            )
    for name, values in layout.names.items():
        if names.get(name) != values:
            raise WorkError(
                f"{name}: this scene has {', '.join(map(str, names.get(name, ('none',))))}, the campaign "
                f"{', '.join(map(str, values))}. Set the same sensors, probes and shafts in all scenes."
            )
    arrays = {one.name: read(motion, found[one.name], slice(None)) for one in layout.signals}
    return {name: np.ascontiguousarray(np.moveaxis(one, 0, -1)) for name, one in arrays.items()}  # time last


def read_facts(folder: str | Path) -> dict[str, Any]:
    """The contents of campaign.json.

    Raises
    ------
    InputError : the folder is not that of a campaign
    """
    path = Path(folder) / FACTS
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
        stored["identity"], stored["runs"], stored["facts"]["plan"], stored_layout(stored["layout"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        reason = f"it has no {FACTS}" if isinstance(error, FileNotFoundError) else shown(str(error))
        raise InputError(
            f"{shown(folder)}: not the folder of a data set ({reason}). Give the folder that `gearcase campaign` wrote."
        ) from error
    return stored


def stored_layout(stored: dict[str, Any]) -> RunLayout:
    """The layout in campaign.json. KeyError or TypeError if it is not a layout."""
    signals = tuple(
        SignalLayout(
            name=one["name"],
            dims=tuple(one["dims"]),
            shape=tuple(one["shape"]),
            dtype=one["dtype"],
            attributes=one["attributes"],
        )
        for one in stored["signals"]
    )
    names = {name: tuple(values) for name, values in stored["names"].items()}
    return RunLayout(signals=signals, names=names, samples=stored["samples"], rate=stored["rate"])
