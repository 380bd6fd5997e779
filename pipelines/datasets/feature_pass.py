"""Features of all runs, computed from the stored signals; the computation can be interrupted and continued.

Each run has a row in `feature_rows`. It holds the checksums of the signals and the version of the code, so that the
features are computed again when a run was simulated again or the computation has changed. features.parquet is made
from these rows, with a line for each run, sensor and axis.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
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
from pipelines.scene.train import stage_shafts
from pipelines.signals.features.average import FEWEST_TURNS, Meshes, average
from pipelines.signals.features.statistics import statistics
from pipelines.signals.features.synchronous import synchronous
from pipelines.signals.features.turns import cut_turns
from pipelines.signals.orders.revolutions import moving_stretches
from pipelines.signals.orders.rotation import Rotation

FEATURE_ROWS = "feature_rows"
FEATURES = "features.parquet"
ANGLE = "shaft_angle"


@dataclass(frozen=True, kw_only=True)
class FeatureJob(RowJob):
    """Computation of the features of a run from its signal, shaft angles and mesh orders."""

    signal: str
    sensors: tuple[str, ...]
    axes: tuple[str, ...]
    shafts: tuple[str, ...]  # empty if their angles were not stored
    meshes: tuple[Mapping[int, int], ...]
    rate: float
    start: float
    noise: float

    @property
    def rows(self) -> str:
        """The folder of the rows."""
        return FEATURE_ROWS

    @property
    def made_of(self) -> dict[str, Any]:
        """Everything that the features depend on: code, checksums of the signals, start, and noise."""
        code = code_version(
            "pipelines.signals.features.statistics",
            "pipelines.signals.features.synchronous",
            "pipelines.signals.features.turns",
        )
        return {"code": code, "start_s": self.start, "noise_m_s2": self.noise, "checksums": self.checksums}

    def computed(self) -> dict[str, Any]:
        """The features of every channel."""
        return {"channels": list(_channels(self))}


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


def _jobs(folder: Path, facts: Mapping[str, Any], start: float, noise: float) -> Iterator[FeatureJob]:
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
    angle = ANGLE in stored
    for row in read_rows(folder):
        if row["status"] == DONE:
            yield FeatureJob(
                folder=folder,
                run=row["run"],
                signal=signal,
                sensors=tuple(layout["names"]["sensor" if signal == VIBRATION[0] else "bearing"]),
                axes=tuple(layout["names"]["axis"]),
                shafts=tuple(layout["names"]["shaft"]) if angle else (),
                meshes=tuple(_shaft_meshes(plan, row["values"])),
                rate=layout["rate"],
                start=start,
                noise=noise,
                checksums=[row["checksums"].get(name) for name in (signal, ANGLE)],
            )


def _channels(job: FeatureJob) -> Iterator[dict[str, Any]]:
    """The features of every channel; None for a feature without a finite value."""
    first = math.ceil(job.start * job.rate)
    stored = read_run(job.folder, job.run, job.signal)
    signal = noisy_run(stored, job.run, job.sensors, job.axes, job.noise, seed=0)[..., first:].astype(float)
    time = np.arange(signal.shape[-1]) / job.rate
    found = statistics(signal)
    if job.shafts:
        angles = read_run(job.folder, job.run, ANGLE)[:, first:]
        for shaft, angle, meshes in zip(job.shafts, angles, job.meshes, strict=True):
            of_shaft = _of_shaft(signal, time, angle, meshes)
            found |= {f"{shaft}_{name}": values for name, values in of_shaft.items()}
    for i, sensor in enumerate(job.sensors):
        for j, axis in enumerate(job.axes):
            values = {name: float(value[i, j]) for name, value in found.items()}
            finite = {name: value if math.isfinite(value) else None for name, value in values.items()}
            yield {"sensor": sensor, "axis": axis, **finite}


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
