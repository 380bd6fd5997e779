"""Arguments of the commands that read finished runs and recordings."""

from __future__ import annotations

import argparse

from pipelines.border.argument_types import count, days, number, path, positive, several

RUN_HELP = "result folder, name of a scene for its newest result, or number in `gearcase runs`"


def json_argument(sub: argparse.ArgumentParser) -> None:
    """--json."""
    sub.add_argument("--json", action="store_true", help="print what was found as JSON, for programs")


def diagnose_arguments(sub: argparse.ArgumentParser) -> None:
    """A recording, its machine, healthy ones."""
    sub.add_argument(
        "run",
        metavar="RECORD",
        type=path,
        help=f"recorded file, {RUN_HELP}",
    )
    sub.add_argument("--machine", metavar="FILE", type=path, help="what a file was recorded on: teeth, speed, sensors")
    sub.add_argument(
        "--baseline",
        metavar="RECORD",
        type=path,
        nargs="+",
        default=[],
        help="recordings of healthy machines; p-values take 5 or more",
    )
    sub.add_argument(
        "--window", metavar=("START", "END"), type=number, nargs=2, help="seconds that are looked at (default: all)"
    )
    sub.add_argument(
        "--set",
        metavar="KEY=VALUE",
        dest="settings",
        action="append",
        default=[],
        help="look elsewhere, as in --set diagnosis.sensor=sensor_5; repeatable",
    )
    json_argument(sub)


def compare_arguments(sub: argparse.ArgumentParser) -> None:
    """Recordings, and what of them is shown."""
    sub.add_argument(
        "recordings",
        metavar="RECORD",
        type=path,
        nargs="+",
        help="recorded file, or a run by folder, scene or number; a part of it by RECORD@lifting or RECORD@0.5:2.5",
    )
    sub.add_argument("--machine", metavar="FILE", type=path, help="what was recorded: teeth, speed, sensors")
    sub.add_argument("--sensor", metavar="NAME", help="of the figures (default: the strongest)")
    sub.add_argument("--axis", choices=("x", "y", "z"), help="of the figures (default: the strongest)")
    sub.add_argument("--shaft", metavar="N", type=count, help="of the averages (default: whose features differ most)")
    sub.add_argument("--out", metavar="FOLDER", type=path, help="for the figures and the CSV (default: ./comparison)")


def _run_folder(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "run",
        metavar="RUN",
        type=path,
        help=RUN_HELP,
    )


def runs_arguments(sub: argparse.ArgumentParser) -> None:
    """list, open, compare and clean; list without any."""
    json_argument(sub)
    sub.set_defaults(scene=None)
    actions = sub.add_subparsers(dest="action", metavar="ACTION", title="actions (default: list)")

    def action(name: str, words: str) -> argparse.ArgumentParser:
        made = actions.add_parser(name, help=words, description=f"{words[0].upper()}{words[1:]}.", allow_abbrev=False)
        made.add_argument("-v", "--verbose", action="store_true", default=argparse.SUPPRESS, help="log, tracebacks")
        return made

    listing = action("list", "list the runs under ./runs, newest first")
    listing.add_argument("scene", metavar="SCENE", nargs="?", help="only the runs of this scene")
    listing.add_argument("--json", action="store_true", default=argparse.SUPPRESS, help="print them as JSON")
    action("open", "open the report of a run in the browser").add_argument(
        "run", metavar="RUN", type=path, help=RUN_HELP
    )
    action("compare", "lay runs side by side: verdicts, settings, levels").add_argument(
        "runs", metavar="RUN", type=path, nargs="+", help=RUN_HELP
    )
    clean = action("clean", "show which runs would be removed; with --yes remove them")
    clean.add_argument("runs", metavar="RUN", type=path, nargs="*", help=RUN_HELP)
    clean.add_argument("--older-than", metavar="DAYS", type=days, help="only those of a greater age")
    clean.add_argument("--keep", metavar="N", type=count, help="not the newest N of each scene")
    clean.add_argument("--yes", action="store_true", help="remove them")


def export_arguments(sub: argparse.ArgumentParser) -> None:
    """A run and the format of the file."""
    _run_folder(sub)
    sub.add_argument("--to", dest="form", choices=("csv", "mat", "uff"), required=True, help="file format")
    sub.add_argument(
        "--out",
        metavar="FILE",
        type=path,
        help="file to write (default: response.csv, .mat or .uff in the run folder)",
    )


def orders_arguments(sub: argparse.ArgumentParser) -> None:
    """A run and the orders that are shown."""
    _run_folder(sub)
    sub.add_argument("--shaft", metavar="N", type=count, help="whose orders are counted (default: the driven one)")
    sub.add_argument("--sensor", metavar="NAME", help="default: that of the diagnosis, or the first")
    sub.add_argument("--axis", choices=("x", "y", "z"), help="of the sensor (default: that of the diagnosis)")
    sub.add_argument("--orders", metavar="K", type=positive, nargs="+", default=[], help="cuts (default: mesh orders)")
    sub.add_argument("--revolutions", metavar="N", type=several, default=16, help="of a window (default 16)")
    sub.add_argument("--campbell", action="store_true", help="natural frequencies over speed as well")
    sub.add_argument("--out", metavar="FOLDER", type=path, help="folder for the pictures (default: that of the run)")
    sub.add_argument("-q", "--quiet", action="store_true", help="no progress")
