"""Feature tables of the runs of a data set, one row for each run; interrupted work is resumed.

The noise is added to the stored signals. Another noise therefore needs no simulation. A row holds the checksums of the
signals and the version of the code, so that only missing and outdated features are computed.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.datasets.campaign_scenes import scene_of
from pipelines.datasets.dataset_reading import VIBRATION
from pipelines.datasets.plan import stored_plan
from pipelines.datasets.rows import DONE, numbers, read_row, read_rows, row_path, sweep_rows, write_row
from pipelines.datasets.signal_layout import RunLayout, read_facts, stored_layout
from pipelines.datasets.store import read_run
from pipelines.diagnosis.simulated_features import FeatureSettings, run_features
from pipelines.engine.code_version import code_version
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.machine.layout import lay_out
from pipelines.machine.scene_bearings import rolling_bearings
from pipelines.machine.scene_kinematics import kinematics_of
from pipelines.signals.features.feature_table import FeatureTable
from pipelines.signals.features.recording_features import FeatureError
from pipelines.signals.orders.rotation import RotationError

if TYPE_CHECKING:
    import xarray

FEATURE_ROWS = "feature_rows"
Window = tuple[float, float]
Progress = Callable[[int, int], None]
_Task = tuple[int, FeatureSettings, Mapping[str, Any]]  # run, settings, and what its row is made of


def dataset_rows(
    folder: Path,
    windows: Mapping[str, Window],
    noise: float,
    executor: Executor,
    on_progress: Progress,
    *,
    rows: str = FEATURE_ROWS,
    complete: bool = True,
) -> Iterator[dict[str, Any]]:
    """Rows of the features of all finished runs, in their order; missing and outdated ones are computed.

    Parameters
    ----------
    folder : of the data set
    windows : start and end (s) of the parts to evaluate, by name; the whole runs if empty
    noise : rms (m/s2) of added white noise
    executor, on_progress : of the work
    rows : folder of the rows in that of the data set
    complete : see `pipelines.diagnosis.simulated_features.FeatureSettings`

    Raises
    ------
    InputError : the data set holds no accelerations, or a window is not in its runs
    OSError : a row cannot be written
    """
    facts = read_facts(folder)
    stored = [one["name"] for one in facts["layout"]["signals"]]
    if not set(VIBRATION) & set(stored):
        raise InputError(
            f"{shown(folder)}: the data set holds no accelerations, only {', '.join(stored)}. Add them to `signals` "
            "of the plan."
        )
    length = facts["layout"]["samples"] / facts["layout"]["rate"]
    for start, end in windows.values():
        if not 0.0 <= start < min(end, length) or length * (1.0 + 1e-9) < end < math.inf:
            raise InputError(
                f"from {start:g} to {end:g} s: the runs last {length:g} s. Set a start and a later end within it."
            )
    windows = {name: (start, min(end, length)) for name, (start, end) in windows.items()}
    plan, code = stored_plan(facts), code_version("pipelines.diagnosis.simulated_features")
    same = {"code": code, "windows": {name: list(ends) for name, ends in windows.items()}, "noise_m_s2": noise}
    done = {row["run"]: row for row in read_rows(folder) if row["status"] == DONE}
    for run in numbers(folder, rows) - done.keys():
        row_path(folder, run, rows).unlink(missing_ok=True)
    tasks: list[_Task] = []
    for run, row in done.items():
        made_of = {**same, "checksums": row["checksums"]}
        if not _is_stored(folder, run, rows, made_of):
            scene = scene_of(plan, row["values"]).scene
            kinematics = kinematics_of(lay_out(scene, plan.name), rolling_bearings(scene))
            tasks.append((run, FeatureSettings(kinematics=kinematics, windows=windows, complete=complete), made_of))
    (folder / rows).mkdir(parents=True, exist_ok=True)
    for count, _ in enumerate(executor.map(partial(_write_features, folder, rows), tasks), 1):
        on_progress(count, len(tasks))
    sweep_rows(folder, rows)
    yield from read_rows(folder, rows)


def _is_stored(folder: Path, run: int, rows: str, made_of: Mapping[str, Any]) -> bool:
    """Whether the row of a run is there and made in this way."""
    try:
        return read_row(folder, run, rows).get("made_of") == made_of
    except InputError:
        return False


def _write_features(folder: Path, rows: str, task: _Task) -> None:
    """Write the row of a run: the table of its features, or the reason why there is none."""
    run, settings, made_of = task
    recording = recording_of(folder, run, stored_layout(read_facts(folder)["layout"]))
    found: dict[str, Any] = {"failure": "", "table": None}
    try:
        found["table"] = _plain(run_features(recording.assign_attrs(sensor_noise_m_s2=made_of["noise_m_s2"]), settings))
    except (FeatureError, RotationError) as error:
        found["failure"] = str(error)
    write_row(folder, run, {"run": run, "made_of": made_of, **found}, rows)


def recording_of(folder: Path, run: int, layout: RunLayout) -> xarray.Dataset:
    """The stored signals of a run as a recording."""
    import xarray

    signals = {one.name: (one.dims, read_run(folder, run, one.name)) for one in layout.signals}
    return xarray.Dataset(
        signals,
        coords={
            "time": ("time", np.arange(layout.samples) / layout.rate, {"units": "s"}),
            **{name: list(values) for name, values in layout.names.items()},
        },
    )


def _plain(table: FeatureTable) -> dict[str, Any]:
    """The fields as plain values for JSON."""
    values = {field.name: getattr(table, field.name) for field in dataclasses.fields(table)}
    return {name: value.tolist() if isinstance(value, np.ndarray) else list(value) for name, value in values.items()}


def stored_table(plain: Mapping[str, Any] | None) -> FeatureTable | None:
    """The table of a row; None if the run has none."""
    if plain is None:
        return None
    fields = dict(plain) | {"value": np.reshape(plain["value"], (len(plain["sensor"]), len(plain["component"])))}
    return FeatureTable(**fields)
