"""`gearcase dataset`: count, check, export a data set, or compute features of it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def main(options: argparse.Namespace) -> int:
    """Do what is asked with a data set; 1 if the check finds anything wrong."""
    return ACTIONS[options.action](options)


def _info(options: argparse.Namespace) -> int:
    from pipelines.datasets.summary import summarised

    sys.stdout.write(summarised(Path(options.folder)).to_text())
    return 0


def _check(options: argparse.Namespace) -> int:
    from pipelines.datasets.check import check_dataset
    from pipelines.datasets.shown_progress import lines_now_and_then

    found = check_dataset(Path(options.folder), lines_now_and_then(quiet=options.quiet))
    sys.stdout.write(found.to_text())
    return 1 if found.wrong else 0


def _features(options: argparse.Namespace) -> int:
    from pipelines.datasets.feature_pass import FEATURES, make_features
    from pipelines.datasets.shown_progress import lines_now_and_then
    from pipelines.datasets.workers import local_workers

    folder, told = Path(options.folder), lines_now_and_then(quiet=options.quiet)
    with local_workers(options.processes) as workers:
        made, lines = make_features(folder, workers.executor, options.start, options.noise, told)
    sys.stdout.write(f"features of {made} runs computed now\n{folder / FEATURES}: {lines} lines\n")
    return 0


def _export(options: argparse.Namespace) -> int:
    from pipelines.datasets.export import Wanted, export_dataset

    wanted = Wanted(
        splits=tuple(options.split),
        labels=tuple(options.label),
        sensors=tuple(options.sensors),
        start=options.start,
        seconds=options.seconds,
        overlap=options.overlap,
        noise_m_s2=options.noise,
        seed=options.seed,
    )
    target, count = export_dataset(Path(options.folder), options.form, wanted, options.out)
    sys.stdout.write(f"{count} pieces\n{target}\n")
    return 0


ACTIONS = {"info": _info, "check": _check, "features": _features, "export": _export}
