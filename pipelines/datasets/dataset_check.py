"""Check of a data set: signals, rows, labels and table must agree with one another and with the stored plan.

Runs are read one at a time, so that memory does not grow with their number. Nothing is changed.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from pipelines.datasets.campaign_scenes import SampledScene, sampled_scenes, scene_of
from pipelines.datasets.expressions import ExpressionError
from pipelines.datasets.folder import identity_facts
from pipelines.datasets.labels import labels
from pipelines.datasets.plan import Plan, stored_plan
from pipelines.datasets.rows import DONE, FAILED, ROWS, TABLE, flat, numbers, read_row
from pipelines.datasets.run_warnings import run_warnings
from pipelines.datasets.signal_layout import RunLayout, read_facts, stored_layout
from pipelines.datasets.store import SIGNALS, checksum, chunk_path, read_run
from pipelines.datasets.summary import stretches
from pipelines.io.errors import InputError, SceneError
from pipelines.io.shown_text import shown
from pipelines.machine.checks.checked_machine import checked_machine

AGAIN = "Delete its file in rows/ and repeat the campaign."
_MOST_SHOWN = 50


@dataclass(kw_only=True)
class Findings:
    """Errors by run, warnings of the runs, and notes."""

    runs: int
    rows: int = 0
    wrong: list[str] = field(default_factory=list)
    warnings: tuple[str, ...] = ()
    notes: list[str] = field(default_factory=list)

    def to_text(self) -> str:
        """What `gearcase dataset check` prints."""
        lines = [f"error: {text}" for text in self.wrong[:_MOST_SHOWN]]
        if len(self.wrong) > _MOST_SHOWN:
            lines.append(f"and {len(self.wrong) - _MOST_SHOWN} more errors")
        lines += [f"warning: {text}" for text in self.warnings]
        lines += [f"note: {text}" for text in self.notes]
        counts = f"{_counted(len(self.wrong), 'error')}, {_counted(len(self.warnings), 'warning')}"
        return "".join(f"{line}\n" for line in [*lines, f"{self.rows} rows of {self.runs} runs checked: {counts}"])


def check_dataset(folder: Path, on_progress: Callable[[int, int], None] = lambda done, total: None) -> Findings:
    """Check every row with its signals and labels, and the table.

    Parameters
    ----------
    folder : of the data set
    on_progress : called, with the rows that are checked and all rows

    Raises
    ------
    InputError : the folder holds no data set, or one whose plan this version does not read
    """
    facts = read_facts(folder)
    layout = stored_layout(facts["layout"])
    plan = stored_plan(facts)
    present = numbers(folder)
    found = Findings(runs=facts["runs"], rows=len(present))
    sampled = sampled_scenes(plan)
    if identity_facts(plan, sampled)["draws"] != facts["facts"]["draws"]:
        found.notes.append(
            "the installed libraries sample other values from the plan, so the values in the rows are not checked"
        )
        sampled = []
    firsts: dict[str, dict[str, Any]] = {}
    repeated = 0
    qualities: list[dict[str, Any]] = []
    for count, run in enumerate(sorted(present), 1):
        on_progress(count, len(present))
        try:
            row = read_row(folder, run)
            errors = [*_of_row(row, plan, sampled, facts["runs"]), *_of_signals(folder, row, layout)]
        except InputError as error:
            found.wrong.append(f"run {run}: {error}")
            continue
        except (KeyError, TypeError, AttributeError) as error:
            errors = [f"its row is incomplete ({error!r}). {AGAIN}"]
        if row.get("status") == DONE and row.get("quality"):
            qualities.append(row["quality"])
        if row.get("status") == DONE and row.get("key"):
            first = firsts.setdefault(row["key"], {name: row.get(name) for name in ("run", "split", "checksums")})
            if first["run"] != run:
                repeated += 1
                errors += _of_repeat(first, row)
        found.wrong += [f"run {run}: {text}" for text in errors]
    kinds, step_errors = ([one[name] for one in qualities] for name in ("warnings", "step_error"))
    found.warnings = run_warnings(folder, facts, kinds, step_errors)
    if repeated:
        found.notes.append(
            f"{_counted(repeated, 'run')} with the scene of another run (same key), which random samples may give"
        )
    found.notes += _of_what_is_not_done(folder, layout)
    _check_table(folder, present, found)
    return found


def _of_row(row: Mapping[str, Any], plan: Plan, sampled: Sequence[SampledScene], runs: int) -> Iterator[str]:
    """What is wrong with the values and labels of a row."""
    run = row["run"]
    if run >= runs:
        yield f"the plan has only {runs} runs. Delete its file in rows/."
        return
    if row["status"] not in (DONE, FAILED):
        yield f"its status is {row['status']!r}, allowed: {DONE}, {FAILED}. {AGAIN}"
    if sampled:
        one = sampled[run]
        for name, value in (("values", dict(one.values)), ("group", one.group), ("split", one.split)):
            if row[name] != value:
                yield f"its {name} differ from those of the plan, {_short(row[name])} for {_short(value)}. {AGAIN}"
    if row["status"] == DONE:
        try:
            scene = scene_of(plan, row["values"])
            true = labels(checked_machine(scene.scene, scene.source.shown))
        except (SceneError, ExpressionError) as error:
            yield f"its values do not give a valid scene ({' '.join(str(error).split())}). {AGAIN}"
            return
        for name, value in true.items():
            if row["labels"].get(name) != value:
                label = _short(row["labels"].get(name))
                yield f"its {name} is {label}, that of its scene is {_short(value)}. {AGAIN}"


def _of_signals(folder: Path, row: Mapping[str, Any], layout: RunLayout) -> Iterator[str]:
    """What is wrong with the stored signals of a row that is done."""
    if row["status"] != DONE:
        return
    for one in layout.signals:
        if one.name not in row["checksums"]:
            yield f"its row holds no checksum of {one.name}. {AGAIN}"
        elif not chunk_path(folder, one.name, row["run"], len(one.shape)).is_file():
            yield f"{one.name} is not stored. {AGAIN}"
        else:
            try:
                values = read_run(folder, row["run"], one.name)
            except InputError as error:
                yield str(error)
                continue
            if checksum(values) != row["checksums"][one.name]:
                yield f"{one.name} was changed after it was written (its checksum differs). {AGAIN}"
            elif not np.isfinite(values).all():
                yield f"{one.name} has {int((~np.isfinite(values)).sum())} NaN or infinite values. {AGAIN}"


def _of_repeat(first: Mapping[str, Any], row: Mapping[str, Any]) -> Iterator[str]:
    """What is wrong with two runs of one scene."""
    if first["split"] != row["split"]:
        yield (
            f"is the same scene as run {first['run']}, but one is in the part {row['split']}, the other in "
            f"{first['split']}: the split leaks. Set split.by in the plan so that equal scenes are one group."
        )
    if first["checksums"] != row.get("checksums"):
        yield (
            f"is the same scene as run {first['run']} and has other signals. Delete both rows and repeat the campaign."
        )


def _of_what_is_not_done(folder: Path, layout: RunLayout) -> Iterator[str]:
    """Chunks without a row, as a campaign leaves them that runs or was stopped."""
    names = (name for one in layout.signals for name in os.listdir(folder / SIGNALS / one.name))
    stored = {int(found[1]) for name in names if (found := re.match(r"c\.(\d+)\.", name))}
    if left := tuple(sorted(stored - numbers(folder))):
        runs = _counted(len(left), "run")
        yield f"{runs} without a row, but with signals ({stretches(left)}): the campaign repeats them"


def _check_table(folder: Path, present: set[int], found: Findings) -> None:
    """Compare rows.parquet with the rows."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    again = "Repeat the campaign, which writes the table again."
    path = folder / TABLE
    try:
        if path.stat().st_mtime_ns < (folder / ROWS).stat().st_mtime_ns:
            found.notes.append(f"{TABLE} is older than the newest row; the campaign writes it again at its end")
            return
        lines = {line["run"]: line for line in pq.read_table(path).to_pylist()}
    except FileNotFoundError:
        found.notes.append(f"there is no {TABLE} yet; the campaign writes it at its end")
        return
    except (OSError, KeyError, pa.ArrowException) as error:
        found.wrong.append(f"{TABLE}: cannot be read ({error}). {again}")
        return
    for run, line in lines.items():
        if run not in present:
            found.wrong.append(f"{TABLE}: holds run {run}, which has no row. {again}")
            continue
        with contextlib.suppress(InputError):  # reported for the row itself
            row = flat(read_row(folder, run))
            different = [name for name in line | row if name not in line or line[name] != row.get(name)]
            if different:
                found.wrong.append(f"{TABLE}: {', '.join(different)} of run {run} differ from its row. {again}")
    if absent := tuple(sorted(present - lines.keys())):
        found.wrong.append(f"{TABLE}: the runs {stretches(absent)} are missing. {again}")


def _counted(count: int, name: str) -> str:
    return f"{count} {name}{'' if count == 1 else 's'}"


def _short(value: Any) -> str:
    return shown(value if isinstance(value, str) else json.dumps(value), 120)
