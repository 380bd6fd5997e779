"""Arguments of `gearcase dataset`: what is done with a data set, each with arguments of its own."""

from __future__ import annotations

import argparse

from pipelines.cli.command_help import action_parser
from pipelines.cli.finished_arguments import quiet_argument
from pipelines.io.argument_types import count, from_zero, part, path, positive, whole

_EXAMPLES = {
    "info": "gearcase dataset info campaigns/plan",
    "check": "gearcase dataset check campaigns/plan",
    "features": "gearcase dataset features campaigns/plan --start 0.3",
    "export": "gearcase dataset export campaigns/plan --to npz --split train --seconds 0.25 --noise 0.01",
}


def dataset_arguments(sub: argparse.ArgumentParser) -> None:
    """info, check, features and export."""
    actions = sub.add_subparsers(dest="action", metavar="ACTION", title="actions", required=True)

    def action(name: str, words: str) -> argparse.ArgumentParser:
        made = action_parser(actions, sub, name, words, _EXAMPLES[name])
        made.add_argument("folder", metavar="FOLDER", type=path, help="folder of the data set, as in campaigns/plan")
        return made

    action("info", "print runs, labels, split and variables")
    quiet_argument(action("check", "check that signals, labels and table agree"))
    features = action("features", "compute the features of every run")
    features.add_argument(
        "--start", type=from_zero, metavar="T", default=0.0, help="ignore the signals before this time, s (default 0)"
    )
    features.add_argument(
        "--noise", metavar="RMS", type=from_zero, default=0.0, help="add white sensor noise, m/s2 rms (default 0)"
    )
    features.add_argument(
        "--processes", type=count, metavar="N", help="runs processed at the same time (default: number of cores)"
    )
    quiet_argument(features)
    _export(action("export", "write runs, or pieces of them, with labels for other programs"))


def _export(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "--to",
        dest="form",
        choices=("csv", "mat", "npz", "hdf5"),
        required=True,
        help="file format; npz and hdf5 write one file, csv and mat one file for each run and labels.csv",
    )
    sub.add_argument(
        "--out", metavar="PATH", type=path, help="file, or folder for csv and mat (default: in the data set)"
    )
    sub.add_argument(
        "--split",
        metavar="PART",
        nargs="+",
        default=[],
        help="parts of the split to write: train, validation or test (default: all)",
    )
    sub.add_argument(
        "--label",
        metavar="LABEL",
        nargs="+",
        default=[],
        help="labels whose runs are written, as in healthy (default: all)",
    )
    sub.add_argument("--sensors", metavar="NAME", nargs="+", default=[], help="sensors to write (default: all)")
    sub.add_argument(
        "--start", type=from_zero, metavar="T", default=0.0, help="ignore the signals before this time, s (default 0)"
    )
    sub.add_argument(
        "--seconds", metavar="T", type=positive, help="length of a piece, s (default: the whole run after --start)"
    )
    sub.add_argument(
        "--overlap",
        metavar="S",
        type=part,
        default=0.0,
        help="overlap of neighbouring pieces: 0 to below 1, or as in 50%% (default 0)",
    )
    sub.add_argument(
        "--noise", metavar="RMS", type=from_zero, default=0.0, help="add white sensor noise, m/s2 rms (default 0)"
    )
    sub.add_argument("--seed", metavar="N", type=whole, default=0, help="seed of the noise (default 0)")
