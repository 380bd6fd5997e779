"""Finished runs side by side: what they found, in what their scenes differ, how much each sensor shakes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.io.grid import Grid
from pipelines.io.shown import shown_value
from pipelines.runs.kept_runs import KeptRun, run_settings
from pipelines.runs.run_folder import RESPONSE, opened_run

if TYPE_CHECKING:
    import numpy as np

_LONGEST = 60  # characters of a value


def compared_runs(runs: Sequence[KeptRun]) -> Grid:
    """A column per run: verdict, every setting that is not the same in all, rms of the acceleration at each sensor."""
    settings = [run_settings(run.folder) for run in runs]
    keys = sorted({key for one in settings for key in one})
    rows = [("verdict", *(run.verdict or "not diagnosed" for run in runs))]
    for key in keys:
        values = [one.get(key) for one in settings]
        if any(value != values[0] for value in values):
            rows.append((key, *("(none)" if value is None else shown_value(value, _LONGEST) for value in values)))
    levels = [sensor_levels(run.folder) for run in runs]
    for sensor in dict.fromkeys(name for one in levels for name in one):
        cells = (f"{one[sensor]:.4g}" if sensor in one else "-" for one in levels)
        rows.append((f"{sensor}, m/s2 rms", *cells))
    headers = ("", *(f"run {run.number}: {run.scene}" if run.number else str(run.folder) for run in runs))
    title = "Runs side by side; all other settings are the same. rms: all axes of a sensor, over the whole run"
    return Grid(title=title, headers=headers, rows=tuple(rows))


def sensor_levels(folder: Path) -> dict[str, float]:
    """Root mean square of the acceleration of a run, m/s2, of all axes together, by sensor; none without sensors."""
    with opened_run(folder / RESPONSE) as run:
        if "acceleration" not in run:
            return {}
        values: np.ndarray = run.acceleration.transpose("sensor", "time", "axis").values
        names = [str(name) for name in run.sensor.values]
    return {name: float((one**2).sum(axis=1).mean() ** 0.5) for name, one in zip(names, values, strict=True)}
