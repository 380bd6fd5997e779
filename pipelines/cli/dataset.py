"""`gearcase dataset`: summarise, check or export a data set."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from pipelines.cli.command_line import NOISE, QUIET, START, Printed, argument
from pipelines.io.argument_types import part, path, positive, whole

_FOLDER = argument("folder", metavar="FOLDER", type=path, help="folder of the data set, as in campaigns/plan")
_EXPORT = (
    _FOLDER,
    argument(
        "--to",
        dest="form",
        choices=("csv", "mat", "npz", "hdf5"),
        required=True,
        help="file format; npz and hdf5 write one file, csv and mat one file for each run and labels.csv",
    ),
    argument("--out", metavar="PATH", type=path, help="file, or folder for csv and mat (default: in the data set)"),
    argument(
        "--split",
        metavar="PART",
        nargs="+",
        default=[],
        help="parts of the split to write: train, validation or test (default: all)",
    ),
    argument(
        "--label",
        metavar="LABEL",
        nargs="+",
        default=[],
        help="labels whose runs are written, as in healthy (default: all)",
    ),
    argument("--sensors", metavar="NAME", nargs="+", default=[], help="sensors to write (default: all)"),
    START,
    argument(
        "--seconds", metavar="T", type=positive, help="length of a piece, s (default: the whole run after --start)"
    ),
    argument(
        "--overlap",
        metavar="S",
        type=part,
        default=0.0,
        help="overlap of neighbouring pieces: 0 to below 1, or as in 50%% (default 0)",
    ),
    NOISE,
    argument("--seed", metavar="N", type=whole, default=0, help="seed of the noise (default 0)"),
)
ARGUMENTS = ()
ACTIONS = {  # one line; arguments; text; example with what it prints
    "info": (
        "print runs, labels, split and variables",
        (_FOLDER,),
        """\
Print the numbers of runs by label and by part of the split (train, validation, test), and the range of each variable.
Runs of the same pair of gears are a group, which the split keeps together. Can be used while the campaign is running.
Takes seconds.""",
        """\
gearcase dataset info campaigns/plan
...
  runs     6: 6 done
...
  labels   6 healthy
  split    4 train, 2 test; 6 groups of one scene, all with the same pair of gears (deviations.seed is constant)
...""",
    ),
    "check": (
        "check that signals, labels and table agree",
        (_FOLDER, QUIET),
        """\
Check the signals against their checksums, and the table of runs and labels against the plan. Print what is wrong and
what to do; the exit code is then 1. Takes seconds to minutes.""",
        """\
gearcase dataset check campaigns/plan
6 rows of 6 runs checked: 0 errors, 0 warnings""",
    ),
    "export": (
        "write runs, or pieces of them, with labels for other programs",
        _EXPORT,
        """\
Write runs, or pieces of them of equal length, with their labels to a file for other programs. The data set itself is
not changed. Takes seconds to minutes.""",
        """\
gearcase dataset export campaigns/plan --to npz --split train --seconds 0.25 --noise 0.01
16 pieces
...""",
    ),
}


def main(options: argparse.Namespace) -> Iterator[str]:
    """Summarise, check or export a data set of `gearcase campaign`. Takes seconds to minutes.

    Example
    -------
    gearcase dataset info campaigns/plan
    ...
      labels   6 healthy
      split    4 train, 2 test; 6 groups of one scene, all with the same pair of gears (deviations.seed is constant)
    ...
    """
    return {"info": _info, "check": _check, "export": _export}[options.action](options)


def _info(options: argparse.Namespace) -> Iterator[str]:
    from pipelines.datasets.summary import summarised

    yield summarised(Path(options.folder)).to_text()


def _check(options: argparse.Namespace) -> Printed:
    from pipelines.datasets.dataset_check import check_dataset
    from pipelines.engine.progress import reported_count

    with reported_count("runs", quiet=options.quiet) as report:
        found = check_dataset(Path(options.folder), report)
    yield found.to_text()
    return int(bool(found.wrong))


def _export(options: argparse.Namespace) -> Iterator[str]:
    from pipelines.datasets.dataset_export import export_dataset

    target, count = export_dataset(
        Path(options.folder),
        options.form,
        options.out,
        splits=options.split,
        labels=options.label,
        sensors=options.sensors,
        start=options.start,
        seconds=options.seconds,
        overlap=options.overlap,
        noise_m_s2=options.noise,
        seed=options.seed,
    )
    yield f"{count} pieces\n{target}"
