"""Arguments of `gearcase dataset`: what is done with a data set, each with arguments of its own."""

from __future__ import annotations

import argparse

from pipelines.border.argument_types import count, from_zero, part, path, positive, whole

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
        made = actions.add_parser(
            name,
            help=words,
            description=f"{words[0].upper()}{words[1:]}.",
            epilog=f"example:\n  {_EXAMPLES[name]}",
            formatter_class=sub.formatter_class,
            allow_abbrev=False,
        )
        made.add_argument("folder", metavar="FOLDER", type=path, help="of the data set, as in campaigns/plan")
        made.add_argument("-v", "--verbose", action="store_true", default=argparse.SUPPRESS, help="log, tracebacks")
        return made

    action("info", "count runs, labels and parts, and say what was varied; also while it grows")
    action("check", "compare signals, rows, labels and table with one another; 1 if anything is wrong")
    features = action("features", "compute features of every run into features.parquet; goes on where it was stopped")
    features.add_argument("--start", type=from_zero, metavar="T", default=0.0, help="leave out what is before (0 s)")
    features.add_argument("--noise", metavar="RMS", type=from_zero, default=0.0, help="add sensor noise, m/s2 (0)")
    features.add_argument("--processes", type=count, metavar="N", help="runs at the same time (default: all cores)")
    _export(action("export", "write runs, or pieces of them, for NumPy, MATLAB and others, with their labels"))


def _export(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "--to",
        dest="form",
        choices=("csv", "mat", "npz", "hdf5"),
        required=True,
        help="npz and hdf5: one file; csv and mat: a file per run and labels.csv",
    )
    sub.add_argument("--out", metavar="PATH", type=path, help="file, or folder for csv and mat (in the data set)")
    sub.add_argument("--split", metavar="PART", nargs="+", default=[], help="as in train (default: all)")
    sub.add_argument("--label", metavar="LABEL", nargs="+", default=[], help="as in healthy (default: all)")
    sub.add_argument("--sensors", metavar="NAME", nargs="+", default=[], help="default: all")
    sub.add_argument("--seconds", metavar="T", type=positive, help="length of a piece (default: the whole run)")
    sub.add_argument("--overlap", metavar="S", type=part, default=0.0, help="share of a piece in the next one (0)")
    sub.add_argument("--noise", metavar="RMS", type=from_zero, default=0.0, help="white sensor noise in m/s2 (0)")
    sub.add_argument("--seed", metavar="N", type=whole, default=0, help="of the noise (0)")
