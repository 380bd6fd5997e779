"""Features of the runs of a campaign, one row per run and level of noise: a pass that goes on where it was stopped.

Noise is added to the stored signals, so that another level of it takes no simulation.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.datasets.layout import RunLayout, read_facts, stored_layout
from pipelines.datasets.rows import read_row, sweep_rows, write_row
from pipelines.datasets.store import read_run
from pipelines.diagnosis.simulated import FeatureSettings, run_features
from pipelines.engine.code_version import code_version
from pipelines.io.errors import InputError
from pipelines.signals.features.recorded import FeatureError
from pipelines.signals.features.table import FeatureTable
from pipelines.signals.orders.rotation import RotationError

if TYPE_CHECKING:
    import xarray

TABLES = "feature_tables"


@dataclass(frozen=True, kw_only=True)
class TableJob:
    """A run of a campaign whose features are wanted; `checksums` are those of its signals."""

    folder: Path
    run: int
    settings: FeatureSettings
    noise: float  # rms, m/s2
    checksums: Mapping[str, Any]

    @property
    def rows(self) -> str:
        """The folder of its row in the data set."""
        return f"{TABLES}/{self.noise:g}"

    @property
    def made_of(self) -> dict[str, Any]:
        """What its features hang on."""
        windows = {name: list(window) for name, window in self.settings.windows.items()}
        code = code_version("pipelines.diagnosis.simulated")
        return {"code": code, "windows": windows, "noise_m_s2": self.noise, "checksums": dict(self.checksums)}


def make_tables(
    jobs: Sequence[TableJob], executor: Executor, told: Callable[[int, int], None] = lambda done, left: None
) -> list[FeatureTable | None]:
    """The features of all jobs; None for a run that has none, whose row says why.

    Parameters
    ----------
    jobs : all of one data set
    executor : of the work
    told : is told how many of how many are done

    Raises
    ------
    InputError : no run has features: why the first one has none
    OSError : a row cannot be written
    """
    for folder in {job.folder / job.rows for job in jobs}:
        folder.mkdir(parents=True, exist_ok=True)
    left = [job for job in jobs if _made(job) is None]
    for count, _ in enumerate(executor.map(write_table, left), 1):
        told(count, len(left))
    for folder, name in {(job.folder, job.rows) for job in jobs}:
        sweep_rows(folder, name)
    rows = [read_row(job.folder, job.run, job.rows) for job in jobs]
    found = [_table(row["table"]) for row in rows]
    if rows and all(table is None for table in found):
        raise InputError(f"no run has features. The first: {rows[0]['failure']}")
    return found


def write_table(job: TableJob) -> None:
    """Compute the features of a run and write their row."""
    layout = stored_layout(read_facts(job.folder)["layout"])
    recording = recording_of(job.folder, job.run, layout).assign_attrs(sensor_noise_m_s2=job.noise)
    table, failure = None, ""
    try:
        table = run_features(recording, job.settings, stream=job.run)
    except (FeatureError, RotationError) as error:
        failure = str(error)
    row = {"run": job.run, "made_of": job.made_of, "failure": failure, "table": table and _plain(table)}
    write_row(job.folder, job.run, row, job.rows)


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


def _made(job: TableJob) -> dict[str, Any] | None:
    """The row of a job if it is there and made in this way."""
    try:
        row = read_row(job.folder, job.run, job.rows)
    except InputError:
        return None
    return row if row.get("made_of") == job.made_of else None


def _plain(table: FeatureTable) -> dict[str, Any]:
    """The fields as JSON holds them."""
    values = {field.name: getattr(table, field.name) for field in dataclasses.fields(table)}
    return {name: value.tolist() if isinstance(value, np.ndarray) else list(value) for name, value in values.items()}


def _table(plain: Mapping[str, Any] | None) -> FeatureTable | None:
    if plain is None:
        return None
    fields = dict(plain) | {"value": np.reshape(plain["value"], (len(plain["sensor"]), len(plain["component"])))}
    return FeatureTable(**fields)
