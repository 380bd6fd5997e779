"""`gearcase dataset`: count, check, export a data set, or compute features of it."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

_LINE_SECONDS = 30.0


def main(options: argparse.Namespace) -> int:
    """Do what is asked with a data set; 1 if the check finds anything wrong."""
    return ACTIONS[options.action](options)


def _info(options: argparse.Namespace) -> int:
    from pipelines.dataset.summary import summarised

    sys.stdout.write(summarised(Path(options.folder)).to_text())
    return 0


def _check(options: argparse.Namespace) -> int:
    from pipelines.dataset.passes.check import check_dataset

    found = check_dataset(Path(options.folder), _lines())
    sys.stdout.write(found.to_text())
    return 1 if found.wrong else 0


def _features(options: argparse.Namespace) -> int:
    from pipelines.campaign.workers import local_workers
    from pipelines.dataset.passes.feature_pass import FEATURES, make_features

    folder = Path(options.folder)
    with local_workers(options.processes) as workers:
        made, lines = make_features(folder, workers.executor, options.start, options.noise, _lines())
    sys.stdout.write(f"features of {made} runs computed now\n{folder / FEATURES}: {lines} lines\n")
    return 0


def _export(options: argparse.Namespace) -> int:
    from pipelines.dataset.export import Wanted, export_dataset

    wanted = Wanted(
        splits=tuple(options.split),
        labels=tuple(options.label),
        sensors=tuple(options.sensors),
        seconds=options.seconds,
        overlap=options.overlap,
        noise_m_s2=options.noise,
        seed=options.seed,
    )
    target, count = export_dataset(Path(options.folder), options.form, wanted, options.out)
    sys.stdout.write(f"{count} pieces\n{target}\n")
    return 0


def _lines() -> Callable[[int, int], None]:
    """Says on standard error, now and then, how far the work is."""
    said = time.monotonic()

    def told(done: int, total: int) -> None:
        nonlocal said
        if time.monotonic() - said >= _LINE_SECONDS:
            said = time.monotonic()
            sys.stderr.write(f"{done} of {total} runs\n")

    return told


ACTIONS = {"info": _info, "check": _check, "features": _features, "export": _export}
