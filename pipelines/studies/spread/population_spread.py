"""The study of the spread: the plan of its campaign, and the table of its features."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.datasets.campaign import run_campaign
from pipelines.datasets.campaign_scenes import group_variables
from pipelines.datasets.columns import as_array
from pipelines.datasets.feature_tables import dataset_rows, stored_table
from pipelines.datasets.plan import Plan, plan_of_study, plan_tables
from pipelines.datasets.rows import read_row
from pipelines.datasets.typical_spread import TYPICAL, typical
from pipelines.datasets.workers import local_workers
from pipelines.engine.progress import reported_count
from pipelines.engine.run_graph import Work
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.machine.machine_model import MachineModel
from pipelines.scene.load_scene import LoadedScene
from pipelines.scene.tables.diagnosis import Monitored
from pipelines.signals.features.feature_table import FeatureTable
from pipelines.studies.spread.sobol_indices import first_order

if TYPE_CHECKING:
    import pandas

FEWEST = 20  # machines, from which a further machine is within their range with a probability of 90 %
SHARES = (0.05, 0.5, 0.95)  # of the machines below the ends of the interval and the median
MEAN = "mean"  # in place of a sensor: the mean of the levels over all channels
_SPECIMEN = "spread_specimen"
_OWN = {"scene", "scenes", "title"}  # keys of a plan that the study sets


@dataclass(frozen=True, kw_only=True)
class FeatureSpread:
    """Result of a study.

    `table` has a row for each channel, component and feature, and for the mean over the channels (`sensor` "mean"):
    `unit` ("dB" for levels), `median`, `low` and `high` (ends of the 90 % interval), an index and its standard error
    `..._error` for each of `variables`, and `remainder`, the share of the variance that no index explains.
    """

    name: str
    table: pandas.DataFrame
    variables: tuple[str, ...]
    machines: int
    left_out: int

    def means(self) -> pandas.DataFrame:
        """The rows of the mean over the channels, the widest interval first."""
        rows = self.table[self.table.sensor == MEAN]
        return rows.loc[(rows.low - rows.high).sort_values(kind="stable").index]


def spread_plan(loaded: LoadedScene, machine: MachineModel, over: str | Path | None, count: int | None) -> Plan:
    """The plan of the campaign.

    Parameters
    ----------
    loaded, machine : the scene, and its machine model
    over : plan with the population; if None the typical one, in which each pair of gears is in two machines, so that
        the variance between machines of equal gears is known
    count : number of machines; if None that of the plan, or 100

    Raises
    ------
    InputError : too few machines, a grid, or no plan
    SceneError : the plan is not valid
    """
    tables: dict[str, Any] = {"design": "latin-hypercube"}
    if over is None:
        variables, settings = typical(loaded.tree, {})
        tables |= {"variables": variables, "settings": settings}
    else:
        tables |= plan_tables(over)[1]
    count = tables.get("scenes", 100) if count is None else count
    if tables["design"] == "grid":
        raise InputError(f'{shown(str(over))}: a grid is no population. Set design = "latin-hypercube" and scenes.')
    if isinstance(count, int) and count < FEWEST:
        raise InputError(f"{count} machines: an interval of 90 % needs {FEWEST} or more. Increase --machines.")
    if over is None:
        tables["variables"][_SPECIMEN]["to"] = count // 2
    title = f"Spread of {loaded.name} over {TYPICAL if over is None else Path(over).stem}"
    own = {"scenes": count, "title": title[:200]}
    kept = {key: value for key, value in tables.items() if key not in _OWN}
    return plan_of_study(loaded, machine, kept | own, f"spread-{loaded.name}")


def run_spread(
    plan: Plan, folder: Path, monitored: Monitored, processes: int | None, building: Work, *, quiet: bool = True
) -> FeatureSpread:
    """Simulate the machines that are missing, and compute the features of all, their intervals and their indices.

    Parameters
    ----------
    plan, folder : plan by `spread_plan`, and folder of the campaign
    monitored : evaluated windows and sensor noise
    processes : machines computed in parallel, all cores if None
    building : how laws and casing of the first machine are built
    quiet : show no progress

    Raises
    ------
    InputError : too few machines have features
    SceneError, WorkError : see `pipelines.datasets.campaign.run_campaign`
    """
    run_campaign(plan, folder, local_workers(processes), building, quiet=quiet)
    with local_workers(processes) as workers, reported_count("machines", quiet=quiet) as report:
        rows = list(dataset_rows(folder, monitored.windows, monitored.noise, workers.executor, report))
    tables = {row["run"]: stored_table(row["table"]) for row in rows}
    found = {run: line_levels(table) for run, table in tables.items() if table is not None}
    if len(found) < FEWEST:
        reason = next((row["failure"] for row in rows if row["failure"]), "see the column reason of rows.parquet")
        raise InputError(f"{len(found)} machines have features, {FEWEST} are needed. Correct the cause: {reason}")
    every = dict.fromkeys(line for levels in found.values() for line in levels)
    lines = [line for line in every if all(line in levels for levels in found.values())]
    values = np.array([[levels[line] for line in lines] for levels in found.values()])
    done = [read_row(folder, run) for run in found]
    columns = {name: as_array([row["values"][name] for row in done]) for name in plan.table.variables}
    inputs = {
        name: column
        for name, column in columns.items()
        if (column.dtype.kind in "fi" and np.isfinite(column).all() and np.ptp(column) > 0.0)
        or (column.dtype.kind == "U" and "" not in column and len(set(column)) > 1)
    }
    if not inputs:
        raise InputError(f"{shown(plan.name)}: no variable differs in all machines. Add one to the plan.")
    index, error = first_order(inputs, values, [row["group"] for row in done], group_variables(plan.table))
    return FeatureSpread(
        name=plan.name,
        table=_table(lines, values, dict(zip(inputs, zip(index, error, strict=True), strict=True))),
        variables=tuple(inputs),
        machines=len(found),
        left_out=len(every) - len(lines),
    )


def line_levels(table: FeatureTable) -> dict[tuple[str, ...], float]:
    """Level (dB), or value of a feature without level, by sensor, axis, component, feature and unit."""
    columns = table.columns()
    levels, values = columns["level_dB"].reshape(table.value.shape), table.value
    plain = np.isnan(levels)
    rows = np.where(plain, values, levels)
    units = np.where(plain.all(axis=0), columns["unit"][: len(table.lines)], "dB")
    channels = [*zip(table.sensor, table.axis, rows, strict=True), (MEAN, "", rows.mean(axis=0))]
    return {
        (sensor, axis, *line, str(unit)): float(value)
        for sensor, axis, row in channels
        for line, unit, value in zip(table.lines, units, row, strict=True)
    }


def _table(
    lines: list[tuple[str, ...]], values: np.ndarray, indices: Mapping[str, tuple[np.ndarray, np.ndarray]]
) -> pandas.DataFrame:
    """One row for each line. The ends are order statistics between which a further machine is with 90 %."""
    import pandas as pd

    low, median, high = np.quantile(values, SHARES, axis=0, method="weibull")
    head = dict(zip(("sensor", "axis", "component", "feature", "unit"), zip(*lines, strict=True), strict=True))
    of_variables = {
        f"{name}{suffix}": value
        for name, pair in indices.items()
        for suffix, value in zip(("", "_error"), pair, strict=True)
    }
    remainder = 1.0 - np.nansum([index for index, _ in indices.values()], axis=0)
    return pd.DataFrame({**head, "median": median, "low": low, "high": high, **of_variables, "remainder": remainder})
