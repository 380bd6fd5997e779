"""`gearcase runs`: list the finished runs, open the report of one, lay them side by side, remove them."""

from __future__ import annotations

import argparse
import sys
import time
from typing import TYPE_CHECKING

from pipelines.cli.command_line import RUN_HELP, action_parsers, json_argument, run_argument
from pipelines.io.argument_types import count, days, path

if TYPE_CHECKING:
    from pipelines.runs.kept_runs import KeptRun

HELP = (
    "List the finished runs under ./runs, open the report of one, compare several, or remove old ones. Takes seconds."
)
EXAMPLE = """\
gearcase runs clean --keep 1
Runs, newest first
run  scene                 folder     age   MB  differs in  verdict
---  -------  -------------------  ------  ---  ----------  -------------
  4  bench    2026-11-25_01-01-40  28 min  3.5  -           not diagnosed
  5  minimal  2026-11-25_00-50-21  40 min  5.6  -           not diagnosed
Nothing was removed. To remove these runs, repeat the command with --yes."""
ACTIONS = {  # one line; text; example with what it prints
    "list": (
        "list the runs under ./runs, newest first",
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
        "Open the report of a run in the browser, and print its path.",
        """\
gearcase runs open bench
runs/bench/2026-11-25_01-02-13/report.html""",
    ),
    "compare": (
        "compare verdicts, settings and sensor levels of runs",
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
        "Show which runs would be removed. With --yes, remove them with all their files.",
        """\
gearcase runs clean 5 --yes
1 run removed, 5.6 MB freed""",
    ),
}


def arguments(sub: argparse.ArgumentParser) -> None:
    """list, open, compare and clean; list without any."""
    json_argument(sub)
    sub.set_defaults(scene=None)
    listing, opened, compared, clean = action_parsers(sub, ACTIONS, title="actions (default: list)")
    listing.add_argument("scene", metavar="SCENE", nargs="?", help="list only the runs of this scene")
    listing.add_argument("--json", action="store_true", default=argparse.SUPPRESS, help="print the list as JSON")
    run_argument(opened)
    compared.add_argument("runs", metavar="RUN", type=path, nargs="+", help=RUN_HELP)
    compared.add_argument("--json", action="store_true", default=argparse.SUPPRESS, help="print the table as JSON")
    clean.add_argument("runs", metavar="RUN", type=path, nargs="*", help=RUN_HELP)
    clean.add_argument("--older-than", metavar="DAYS", type=days, help="remove only runs older than this, days")
    clean.add_argument("--keep", metavar="N", type=count, help="keep the newest N runs of each scene")
    clean.add_argument("--yes", action="store_true", help="remove the runs (default: only list them)")


DAY = 86400.0  # s


def main(options: argparse.Namespace) -> int:
    """Do what is asked with the runs below ./runs."""
    return {"list": _list, "open": _open, "compare": _compare, "clean": _clean}[options.action or "list"](options)


def _list(options: argparse.Namespace) -> int:
    from pipelines.io.json_text import json_text
    from pipelines.runs.kept_runs import differing, kept_runs, run_grid
    from pipelines.runs.run_folder import ROOT

    found = kept_runs(ROOT)
    if options.scene is not None:
        found = tuple(run for run in found if run.scene == options.scene)
    if options.json:
        unlike = differing(found)
        rows = [
            {"run": run.number, "scene": run.scene, "folder": run.folder, "age_s": run.age, "bytes": run.bytes}
            | {"differs_in": unlike[run.number], "verdict": run.verdict or None}
            for run in found
        ]
        sys.stdout.write(json_text(rows))
        return 0
    if not found:
        sys.stdout.write(f"No runs under ./{ROOT}{'' if options.scene is None else f'/{options.scene}'}.\n")
        return 0
    sys.stdout.write(run_grid(found).to_text() + "\n")
    return 0


def _open(options: argparse.Namespace) -> int:
    import webbrowser

    from pipelines.io.errors import InputError
    from pipelines.runs.run_folder import REPORT, find_run

    report = find_run(options.run) / REPORT
    if not report.is_file():
        raise InputError(
            f"{report}: there is no report, because this run was simulated without one. Make one: gearcase run SCENE"
        )
    sys.stdout.write(f"{report}\n")
    webbrowser.open(report.resolve().as_uri())
    return 0


def _compare(options: argparse.Namespace) -> int:
    from pipelines.io.json_text import json_text
    from pipelines.runs.side_by_side import compared_runs

    found = compared_runs([_kept(name) for name in options.runs])
    if options.json:
        sys.stdout.write(json_text([dict(zip(("key", *found.headers[1:]), row, strict=True)) for row in found.rows]))
        return 0
    sys.stdout.write(found.to_text() + "\n")
    sys.stdout.write(f"To compare spectra and features: gearcase compare {' '.join(options.runs)}\n")
    return 0


def _clean(options: argparse.Namespace) -> int:
    from pipelines.io.errors import InputError
    from pipelines.runs.cleaning import chosen, remove_runs
    from pipelines.runs.kept_runs import kept_runs, run_grid
    from pipelines.runs.run_folder import ROOT, find_run

    if not options.runs and options.older_than is None and options.keep is None:
        raise InputError("runs clean: no runs chosen. Give their names, --older-than DAYS or --keep N.")
    age = None if options.older_than is None else DAY * options.older_than
    found = chosen(kept_runs(ROOT), [find_run(name) for name in options.runs], age, options.keep)
    if not found:
        sys.stdout.write("No runs match; nothing was removed.\n")
    elif options.yes:
        sys.stdout.write(
            f"{len(found)} {'run' if len(found) == 1 else 'runs'} removed, {remove_runs(found) / 1e6:.1f} MB freed\n"
        )
    else:
        sys.stdout.write(
            run_grid(found).to_text() + "\nNothing was removed. To remove these runs, repeat the command with --yes.\n"
        )
    return 0


def _kept(name: str) -> KeptRun:
    from pipelines.runs.kept_runs import kept_run
    from pipelines.runs.run_folder import ROOT, find_run, finished_runs

    folder = find_run(name)
    known = [path.resolve() for path in finished_runs(ROOT)]
    number = known.index(folder.resolve()) + 1 if folder.resolve() in known else 0
    return kept_run(number, folder, time.time())
