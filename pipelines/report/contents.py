"""What a report is made of, and how its values are set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pipelines.diagnosis.control_diagnosis import Diagnosis
from pipelines.diagnosis.uncertainty.line_bars import LineBars
from pipelines.io.grid import Grid
from pipelines.report.figures.views import LeftOut
from pipelines.report.first_screen import FirstScreen
from pipelines.signals.analysis import DiagnosisSettings, channel_names

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False, kw_only=True)
class ReportContents:
    """The parts of a report but for its cost; each may be left out, and is then not named.

    Tables are rows of named cells (dicts with equal keys, the keys are the headers); numbers are set to four digits.
    `first` is the first screen. `runs` maps a name ("missing tooth", "healthy", ...) to a response, the run of the
    scene first. `diagnoses` are the comparisons whose lines are shown in full (rope, constant torque), `seeds` those of
    further deviations, which enter the summary. `settings` say what to look at in a run without control. The pictures
    and the stiffness are elements of the page, see `pipelines.report.pictures`.
    """

    title: str
    first: FirstScreen = field(default_factory=FirstScreen)
    summary: Mapping[str, Any] = field(default_factory=dict)
    diagnoses: Sequence[Diagnosis] = ()
    seeds: Sequence[Diagnosis] = ()
    bars: LineBars | str = ""  # of the lines of the first diagnosis, or why there are none
    gears: Sequence[Mapping[str, Any]] = ()
    rolling: Sequence[Mapping[str, Any]] = ()  # bearings with their pass frequencies
    shafts: Sequence[Mapping[str, Any]] = ()  # faults of shafts with their orders
    gear_picture: str | LeftOut | None = None
    stiffness: str = ""
    casing_picture: str | LeftOut | None = None
    casing_rows: Sequence[Mapping[str, Any]] = ()
    runs: Mapping[str, xarray.Dataset] = field(default_factory=dict)
    windows: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    sensor: str = ""  # whose signals are shown
    axis: str = "z"
    settings: DiagnosisSettings | None = None
    energy: Sequence[Mapping[str, Any]] = ()
    cautions: Sequence[str] = ()  # what the motions say about themselves
    warnings: Sequence[str] = ()

    @property
    def channel(self) -> tuple[str, str] | None:
        """Sensor and axis of the verdict, an axis of its own for the resultant; None if the runs do not have it."""
        runs = list(self.runs.values())
        if not runs or any(self.sensor not in channel_names(run) for run in runs):
            return None
        axes = [str(axis) for axis in runs[0].axis.values]
        return self.sensor, self.axis if self.axis in axes else axes[-1]


@dataclass(frozen=True, eq=False, kw_only=True)
class RunCost:
    """What a run has cost: rows of its steps, what was computed, and versions and keys."""

    steps: Sequence[Mapping[str, Any]] = ()
    ledger: Mapping[str, Any] = field(default_factory=dict)
    provenance: Mapping[str, Any] = field(default_factory=dict)


def grid(title: str, rows: Sequence[Mapping[str, Any]]) -> Grid:
    """A table from rows of named cells; a cell that a row lacks stays empty."""
    headers = tuple(dict.fromkeys(name for row in rows for name in row))
    return Grid(title=title, headers=headers, rows=tuple(tuple(cell(row.get(h, "")) for h in headers) for row in rows))


def turned(table: Grid, named: Sequence[str]) -> Grid:
    """A table of many columns laid on its side: a row per quantity, a column per row, headed by the columns `named`."""
    at = [table.headers.index(name) for name in named]
    quantities = [i for i in range(len(table.headers)) if i not in at]
    headers = [" ".join(f"{name} {row[i]}" if row[i].isdigit() else row[i] for name, i in zip(named, at, strict=True))
               for row in table.rows]  # fmt: skip
    rows = tuple((table.headers[i], *(row[i] for row in table.rows)) for i in quantities)
    return Grid(title=table.title, headers=("", *headers), rows=rows)


def cell(value: Any) -> str:
    """A value as it is shown: floats with four significant digits, lists joined, nothing for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, (list, tuple)):
        return ", ".join(cell(v) for v in value)
    return str(value)
