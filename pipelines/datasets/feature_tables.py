"""Feature tables of the runs of a data set, one row for each run and noise; interrupted work is resumed.

The noise is added to the stored signals. Another noise therefore needs no simulation.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.datasets.rows import RowJob, compute_rows, read_row
from pipelines.datasets.signal_layout import RunLayout, read_facts, stored_layout
from pipelines.datasets.store import read_run
from pipelines.diagnosis.simulated_features import FeatureSettings, run_features
from pipelines.engine.code_version import code_version
from pipelines.io.errors import InputError
from pipelines.signals.features.feature_table import FeatureTable
from pipelines.signals.features.recording_features import FeatureError
from pipelines.signals.orders.rotation import RotationError

if TYPE_CHECKING:
    import xarray

TABLES = "feature_tables"


def table_job(
    folder: Path,
    run: int,
    settings: FeatureSettings,
    noise: float,
    checksums: Mapping[str, Any],
    rows: str = "",
) -> RowJob:
    """The task to compute the features of a run.

    Parameters
    ----------
    folder, run : data set, and number of the run
    settings : of the features
    noise : rms of the added sensor noise, m/s2
    checksums : of the stored signals, on which the features depend
    rows : folder of the rows; by default one for each noise
    """
    windows = {name: list(window) for name, window in settings.windows.items()}
    code = code_version("pipelines.diagnosis.simulated_features")
    return RowJob(
        folder=folder,
        run=run,
        rows=rows or f"{TABLES}/{noise:g}",
        made_of={"code": code, "windows": windows, "noise_m_s2": noise, "checksums": dict(checksums)},
        computed=partial(_computed, folder, run, settings, noise),
    )


def _computed(folder: Path, run: int, settings: FeatureSettings, noise: float) -> dict[str, Any]:
    """The table of features, or the reason why there is none."""
    layout = stored_layout(read_facts(folder)["layout"])
    recording = recording_of(folder, run, layout).assign_attrs(sensor_noise_m_s2=noise)
    try:
        return {"failure": "", "table": _plain(run_features(recording, settings))}
    except (FeatureError, RotationError) as error:
        return {"failure": str(error), "table": None}


def make_tables(
    jobs: Sequence[RowJob], executor: Executor, on_progress: Callable[[int, int], None] = lambda done, total: None
) -> list[FeatureTable | None]:
    """The features of all jobs; None for a run without features, whose row states the reason.

    Parameters
    ----------
    jobs : all of one data set
    executor : of the work
    on_progress : callback with the number of finished jobs and that of all

    Raises
    ------
    InputError : no run has features; the message states the reason for the first one
    OSError : a row cannot be written
    """
    compute_rows(jobs, executor, on_progress)
    rows = [read_row(job.folder, job.run, job.rows) for job in jobs]
    found = [stored_table(row["table"]) for row in rows]
    if rows and all(table is None for table in found):
        raise InputError(f"no run has features. The first: {rows[0]['failure']}")
    return found


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
