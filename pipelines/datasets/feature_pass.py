"""Features of all runs, computed from the stored signals; the computation can be interrupted and continued.

Each run has a row in `feature_rows`. It holds the checksums of the signals and the version of the code, so that the
features are computed again when a run was simulated again or the computation has changed. features.parquet is made
from these rows, with a line for each run, sensor and axis.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pipelines.datasets.layout import read_facts
from pipelines.datasets.pieces import noisy_run
from pipelines.datasets.plan import Plan, stored_plan
from pipelines.datasets.reading import VIBRATION
from pipelines.datasets.rows import DONE, RowJob, compute_rows, numbers, read_rows, row_path, write_parquet
from pipelines.datasets.scenes import scene_of
from pipelines.datasets.store import read_run
from pipelines.engine.code_version import code_version
from pipelines.io.errors import InputError
from pipelines.io.shown import shown
from pipelines.scene.shaft_places import stage_shafts
from pipelines.signals.features.average import FEWEST_TURNS, Meshes, average
from pipelines.signals.features.statistics import statistics
from pipelines.signals.features.synchronous import synchronous
from pipelines.signals.features.turns import cut_turns
from pipelines.signals.orders.revolutions import moving_stretches
from pipelines.signals.orders.rotation import Rotation

FEATURE_ROWS = "feature_rows"
FEATURES = "features.parquet"
ANGLE = "shaft_angle"


def make_features(
    folder: Path,
    executor: Executor,
    start: float = 0.0,
    noise: float = 0.0,
    on_progress: Callable[[int, int], None] = lambda done, left: None,
) -> tuple[int, int]:
    """Compute the features of all finished runs and write their table; number of runs computed now, and of lines.

    Parameters
    ----------
    folder : of the data set
    executor : of the computation
    start : time before which signals are ignored, s
    noise : rms of the sensor noise that is added, m/s2, as in `pipelines.datasets.pieces.pieces` with seed 0
    on_progress : called with the number of finished runs and the number of all runs

    Raises
    ------
    InputError : the data set has no accelerations, is damaged, or ends before `start`
    OSError : the features cannot be written
    """
    facts = read_facts(folder)
    jobs = list(_jobs(folder, facts, start, noise))
    for run in numbers(folder, FEATURE_ROWS) - {job.run for job in jobs}:
        row_path(folder, run, FEATURE_ROWS).unlink(missing_ok=True)
    count = compute_rows(jobs, executor, on_progress)
    return count, write_parquet(folder / FEATURES, lambda: _lines(folder))


def _jobs(folder: Path, facts: Mapping[str, Any], start: float, noise: float) -> Iterator[RowJob]:
    layout = facts["layout"]
    stored = [one["name"] for one in layout["signals"]]
    signal = next((name for name in VIBRATION if name in stored), None)
    if signal is None:
        raise InputError(
            f"{shown(folder)}: the data set holds no accelerations, only {', '.join(stored)}. Add them to `signals` "
            "of the plan."
        )
    length = layout["samples"] / layout["rate"]
    if not 0.0 <= start < length:
        raise InputError(f"--start {start:g}: the runs last {length:g} s. Set a time from 0 to below that.")
    plan = stored_plan(facts)
    code = code_version(
        "pipelines.signals.features.statistics",
        "pipelines.signals.features.synchronous",
        "pipelines.signals.features.turns",
    )
    for row in read_rows(folder):
        if row["status"] == DONE:
            sums = [row["checksums"].get(name) for name in (signal, ANGLE)]
            meshes = _shaft_meshes(plan, row["values"]) if ANGLE in stored else []
            yield RowJob(
                folder=folder,
                run=row["run"],
                rows=FEATURE_ROWS,
                made_of={"code": code, "start_s": start, "noise_m_s2": noise, "checksums": sums},
                computed=partial(_computed, folder, row["run"], layout, signal, meshes, start, noise),
            )


def _computed(
    folder: Path,
    run: int,
    layout: Mapping[str, Any],
    signal_name: str,
    meshes: Sequence[Meshes],
    start: float,
    noise: float,
) -> dict[str, Any]:
    """The features of every channel of a run; None for a feature without a finite value.

    Parameters
    ----------
    folder, run : data set, and number of the run
    layout : of the stored signals
    signal_name : of the accelerations
    meshes : numbers of teeth on each shaft by stage; empty if the shaft angles were not stored
    start : time before which signals are ignored, s
    noise : rms of the added sensor noise, m/s2
    """
    names, rate = layout["names"], layout["rate"]
    sensors = names["sensor" if signal_name == VIBRATION[0] else "bearing"]
    first = math.ceil(start * rate)
    stored = read_run(folder, run, signal_name)
    signal = noisy_run(stored, run, sensors, names["axis"], noise, seed=0)[..., first:].astype(float)
    time = np.arange(signal.shape[-1]) / rate
    found = statistics(signal)
    if meshes:
        angles = read_run(folder, run, ANGLE)[:, first:]
        for shaft, angle, of_shaft in zip(names["shaft"], angles, meshes, strict=True):
            features = _of_shaft(signal, time, angle, of_shaft)
            found |= {f"{shaft}_{name}": values for name, values in features.items()}
    channels = []
    for i, sensor in enumerate(sensors):
        for j, axis in enumerate(names["axis"]):
            values = {name: float(value[i, j]) for name, value in found.items()}
            finite = {name: value if math.isfinite(value) else None for name, value in values.items()}
            channels.append({"sensor": sensor, "axis": axis, **finite})
    return {"channels": channels}


def _of_shaft(signal: np.ndarray, time: np.ndarray, angle: np.ndarray, meshes: Meshes) -> dict[str, np.ndarray]:
    """Features of the time-synchronous average over the longest rotation of a shaft; empty if it turns too little."""
    stretches = moving_stretches(angle)
    if not stretches:
        return {}
    longest = max(stretches, key=lambda one: one.stop - one.start)
    rotation = Rotation(angle=angle, source="stored angle", error=0.0, absolute=True)
    window = float(time[longest.start]), float(time[longest.stop - 1])
    cut = cut_turns(signal.reshape(-1, signal.shape[-1]), time, rotation, 1.0, window)
    if cut is None or cut.count < FEWEST_TURNS:
        return {}
    found = synchronous(average(cut.values, cut.orders, meshes))
    return {name: values.reshape(signal.shape[:-1]) for name, values in found.items()}


def _lines(folder: Path) -> Iterator[dict[str, Any]]:
    for row in read_rows(folder, FEATURE_ROWS):
        for channel in row["channels"]:
            yield {"run": row["run"], **channel}


def _shaft_meshes(plan: Plan, values: Mapping[str, Any]) -> list[dict[int, int]]:
    """For each shaft of the scene of these values: the teeth of its gears by the number of their stage.

    SceneError and ExpressionError as in `pipelines.datasets.scenes.scene_of`.
    """
    scene = scene_of(plan, values).scene
    found: list[dict[int, int]] = [{} for _ in scene.shafts]
    for number, (stage, ends) in enumerate(zip(scene.stages, stage_shafts(scene.stages), strict=True), 1):
        for shaft, teeth in zip(ends, (stage.pinion_teeth, stage.wheel_teeth), strict=True):
            found[shaft][number] = teeth
    return found
