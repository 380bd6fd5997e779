"""`gearcase runs`: list the finished runs, open the report of one, compare several, or remove old ones."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from pipelines.cli.command_line import JSON, RUN, RUN_HELP, argument
from pipelines.io.argument_types import count, days, path
from pipelines.io.errors import InputError
from pipelines.io.json_text import json_text
from pipelines.io.shown_text import shown_value
from pipelines.io.text_table import Grid
from pipelines.runs.kept_runs import KeptRun, differing, kept_run, kept_runs, run_grid, run_settings
from pipelines.runs.removed_runs import remove_runs, runs_to_remove
from pipelines.runs.run_folder import REPORT, RESPONSE, ROOT, find_run, finished_runs, opened_run

_JSON = argument("--json", action="store_true", default=argparse.SUPPRESS, help="print the table as JSON")
ARGUMENTS = (JSON,)
DEFAULT_ACTION = "list"
ACTIONS = {  # one line; arguments; text; example with what it prints
    "list": (
        "list the runs under ./runs, newest first",
        (argument("scene", metavar="SCENE", nargs="?", help="list only the runs of this scene"), _JSON),
        "List the finished runs under ./runs, newest first, with the settings in which they differ.",
        """\
gearcase runs list minimal
Runs, newest first
run  scene                 folder     age   MB  differs in               verdict
---  -------  -------------------  ------  ---  -----------------------  -------------
  1  minimal  2026-11-25_01-27-24   2 min  1.1  load.container_kg=80.0   not diagnosed
  5  minimal  2026-11-25_00-50-21  40 min  5.6  load.container_kg=114.0  not diagnosed""",
    ),
    "open": (
        "open the report of a run in the browser",
        (RUN,),
        "Open the report of a run in the browser, and print its path.",
        """\
gearcase runs open bench
runs/bench/2026-11-25_01-02-13/report.html""",
    ),
    "compare": (
        "compare verdicts, settings and sensor levels of runs",
        (argument("runs", metavar="RUN", type=path, nargs="+", help=RUN_HELP), _JSON),
        "Print the verdicts, the settings that differ and the sensor levels of several runs in one table.",
        """\
gearcase runs compare 1 5
Runs side by side; all other settings are the same. rms: all axes of a sensor, over the whole run
                    run 1: minimal  run 5: minimal
------------------  --------------  --------------
...
load.container_kg   80.0            114.0
sensor_3, m/s2 rms  1.227           1.538
...""",
    ),
    "clean": (
        "show which runs would be removed; with --yes remove them",
        (
            argument("runs", metavar="RUN", type=path, nargs="*", help=RUN_HELP),
            argument("--older-than", metavar="DAYS", type=days, help="only runs older than this, days"),
            argument("--keep", metavar="N", type=count, help="keep the newest N runs of each scene"),
            argument("--yes", action="store_true", help="remove the runs (default: only list them)"),
        ),
        """\
Show which runs would be removed. With --yes, remove them with all their files. A run is chosen if it meets all
conditions given: it is named, older than --older-than, and not among the newest --keep of its scene.""",
        """\
gearcase runs clean 5 --yes
1 run removed, 5.6 MB freed""",
    ),
}


DAY = 86400.0  # s
LONGEST = 60  # characters of a value in the table of compared runs


def main(options: argparse.Namespace) -> Iterator[str]:
    """List the finished runs under ./runs, open the report of one, compare several, or remove old ones. Takes
    seconds.

    Example
    -------
    gearcase runs clean --keep 1
    Runs, newest first
    run  scene                 folder     age   MB  differs in  verdict
    ---  -------  -------------------  ------  ---  ----------  -------------
      4  bench    2026-11-25_01-01-40  28 min  3.5  -           not diagnosed
      5  minimal  2026-11-25_00-50-21  40 min  5.6  -           not diagnosed
    Nothing was removed. To remove these runs, repeat the command with --yes.
    """
    return {"list": _list, "open": _open, "compare": _compare, "clean": _clean}[options.action or DEFAULT_ACTION](
        options
    )


def _list(options: argparse.Namespace) -> Iterator[str]:
    found = kept_runs(ROOT)
    scene = getattr(options, "scene", None)  # of the action, if it is given
    if scene is not None:
        found = tuple(run for run in found if run.scene == scene)
    if options.json:
        unlike = differing(found)
        rows = [
            {"run": run.number, "scene": run.scene, "folder": run.folder, "age_s": run.age, "bytes": run.bytes}
            | {"differs_in": unlike[run.number], "verdict": run.verdict or None}
            for run in found
        ]
        yield json_text(rows)
    elif found:
        yield run_grid(found).to_text()
    else:
        yield f"No runs under ./{ROOT}{'' if scene is None else f'/{scene}'}."


def _open(options: argparse.Namespace) -> Iterator[str]:
    import webbrowser

    report = find_run(options.run) / REPORT
    if not report.is_file():
        raise InputError(
            f"{report}: there is no report, because this run was simulated without one. Make one: gearcase run SCENE"
        )
    yield str(report)
    webbrowser.open(report.resolve().as_uri())


def _compare(options: argparse.Namespace) -> Iterator[str]:
    found = compared_runs([_kept(name) for name in options.runs])
    if options.json:
        yield json_text([dict(zip(("key", *found.headers[1:]), row, strict=True)) for row in found.rows])
        return
    yield found.to_text()
    yield f"To compare spectra and features: gearcase compare {' '.join(options.runs)}"


def _clean(options: argparse.Namespace) -> Iterator[str]:
    if not options.runs and options.older_than is None and options.keep is None:
        raise InputError("runs clean: no runs chosen. Give their names, --older-than DAYS or --keep N.")
    age = None if options.older_than is None else DAY * options.older_than
    found = runs_to_remove(kept_runs(ROOT), [find_run(name) for name in options.runs], age, options.keep)
    if not found:
        yield "No runs match; nothing was removed."
    elif options.yes:
        yield f"{len(found)} {'run' if len(found) == 1 else 'runs'} removed, {remove_runs(found) / 1e6:.1f} MB freed"
    else:
        yield run_grid(found).to_text()
        yield "Nothing was removed. To remove these runs, repeat the command with --yes."


def _kept(name: str) -> KeptRun:
    folder = find_run(name)
    known = [path.resolve() for path in finished_runs(ROOT)]
    number = known.index(folder.resolve()) + 1 if folder.resolve() in known else 0
    return kept_run(number, folder, time.time())


def compared_runs(runs: Sequence[KeptRun]) -> Grid:
    """Table with a column for each run: verdict, settings that differ, and rms of the acceleration at each sensor."""
    settings = [run_settings(run.folder) for run in runs]
    keys = sorted({key for one in settings for key in one})
    rows = [("verdict", *(run.verdict or "not diagnosed" for run in runs))]
    for key in keys:
        values = [one.get(key) for one in settings]
        if any(value != values[0] for value in values):
            rows.append((key, *("(none)" if value is None else shown_value(value, LONGEST) for value in values)))
    levels = [sensor_levels(run.folder) for run in runs]
    for sensor in dict.fromkeys(name for one in levels for name in one):
        cells = (f"{one[sensor]:.4g}" if sensor in one else "-" for one in levels)
        rows.append((f"{sensor}, m/s2 rms", *cells))
    headers = ("", *(f"run {run.number}: {run.scene}" if run.number else str(run.folder) for run in runs))
    title = "Runs side by side; all other settings are the same. rms: all axes of a sensor, over the whole run"
    return Grid(title=title, headers=headers, rows=tuple(rows))


def sensor_levels(folder: Path) -> dict[str, float]:
    """Root mean square of the acceleration by sensor, m/s2, of all axes together; empty for a run without sensors."""
    with opened_run(folder / RESPONSE) as run:
        if "acceleration" not in run:
            return {}
        rms = (run.acceleration**2).sum("axis").mean("time") ** 0.5
        return {str(name): float(level) for name, level in zip(run.sensor.values, rms.values, strict=True)}
