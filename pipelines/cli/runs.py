"""`gearcase runs`: list the finished runs, open the report of one, lay them side by side, remove them."""

from __future__ import annotations

import argparse
import sys
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pipelines.runs.kept_runs import KeptRun

DAY = 86400.0  # s


def main(options: argparse.Namespace) -> int:
    """Do what is asked with the runs below ./runs."""
    return ACTIONS[options.action or "list"](options)


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


ACTIONS = {"list": _list, "open": _open, "compare": _compare, "clean": _clean}
