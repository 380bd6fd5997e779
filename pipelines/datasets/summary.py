"""What a data set holds at this moment, counted over its rows."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipelines.datasets.campaign_scenes import group_words
from pipelines.datasets.columns import counted, read_columns
from pipelines.datasets.folder import PLAN
from pipelines.datasets.rows import DONE
from pipelines.datasets.run_warnings import run_warnings
from pipelines.datasets.signal_layout import read_facts
from pipelines.datasets.store import SIGNALS
from pipelines.datasets.variables_grid import design_words, varied_grid
from pipelines.io.text_table import WIDTH
from pipelines.io.toml_text import read_toml

_MOST_RUNS = 10  # stretches of missing runs that are named


@dataclass(frozen=True, eq=False, kw_only=True)
class Summary:
    """Counts by value, runs without a row, warnings of the runs, bytes on the disk, and the columns that were "
    "counted."""

    title: str
    statuses: Mapping[str, int]
    labels: Mapping[str, int]
    splits: Mapping[str, int]
    groups: int
    missing: tuple[int, ...]
    warnings: tuple[str, ...]
    bytes: int
    facts: Mapping[str, Any]
    columns: Mapping[str, np.ndarray]

    def to_text(self) -> str:
        """What `gearcase dataset info` prints."""
        layout, plan = self.facts["layout"], self.facts["facts"]["plan"]
        seconds = layout["samples"] / layout["rate"]
        missing = f"; without a row: {stretches(self.missing)}" if self.missing else ""
        lines = [
            self.title,
            f"  runs     {self.facts['runs']}: {words(self.statuses)}{missing}",
            f"  signals  {', '.join(one['name'] for one in layout['signals'])}; {seconds:g} s at {layout['rate']:g} Hz",
            f"  bytes    {self.bytes / 1e6:.1f} MB of signals",
            f"  labels   {words(self.labels)}",
            f"  split    {words(self.splits)}; {self.groups} {group_words(self.facts['groups by'])}",
            f"  design   {design_words(plan)}",
            *(f"  warnings {text}" for text in self.warnings or ("none",)),
        ]
        table = varied_grid(plan, self.columns)
        if table.rows:
            lines += [f"  {line}".rstrip() for line in table.to_text(WIDTH - 2).splitlines()[1:]]
        return "".join(f"{line}\n" for line in lines)


def summarised(folder: Path) -> Summary:
    """Count what is there. InputError where this is no data set or a row is damaged."""
    facts = read_facts(folder)
    columns = read_columns(folder, facts["runs"])
    done = columns["status"] == DONE
    of_done: dict[str, np.ndarray] = {name: columns[name][done] for name in ("label", "split") if name in columns}
    warnings: tuple[str, ...] = ()
    if "warnings" in columns:  # else no run is done
        warnings = run_warnings(folder, facts, columns["warnings"][done], columns["step_error"][done])
    return Summary(
        title=title(folder, facts),
        statuses=counted(columns, "status"),
        labels=counted(of_done, "label"),
        splits=counted(of_done, "split"),
        groups=len({str(group) for group in columns.get("group", ()) if group}),
        warnings=warnings,
        missing=tuple(int(run) for run in np.flatnonzero(columns["status"] == "")),
        bytes=sum(_sizes(folder / SIGNALS)),
        facts=facts,
        columns=columns,
    )


def title(folder: Path, facts: Mapping[str, Any]) -> str:
    """What the plan is called."""
    return str(plan_texts(folder).get("title") or facts["name"])


def plan_texts(folder: Path) -> dict[str, Any]:
    """The stored plan.toml as it was written; empty where it cannot be read."""
    try:
        return read_toml((folder / PLAN).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def words(counts: Mapping[str, int]) -> str:
    """Counts with their names."""
    return ", ".join(f"{count} {name}" for name, count in counts.items()) or "none yet"


def stretches(runs: tuple[int, ...]) -> str:
    """Numbers of runs, those that follow one another as 3-7."""
    found = np.split(np.array(runs), np.flatnonzero(np.diff(runs) > 1) + 1)
    shown = [f"{one[0]}-{one[-1]}" if len(one) > 1 else str(one[0]) for one in found[:_MOST_RUNS]]
    return ", ".join(shown) + (" ..." if len(found) > _MOST_RUNS else "")


def _sizes(folder: Path) -> Iterator[int]:
    """Sizes of all files below a folder."""
    for place, _, names in os.walk(folder):
        for name in names:
            with contextlib.suppress(FileNotFoundError):  # moved into its place meanwhile
                yield os.stat(os.path.join(place, name)).st_size
