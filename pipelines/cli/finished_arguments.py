"""Arguments of the commands that read finished runs and recordings."""

from __future__ import annotations

import argparse

from pipelines.cli.command_help import action_parser
from pipelines.io.argument_types import count, days, number, path, positive, several

RUN_HELP = "result folder, name of a scene for its newest result, or number that `gearcase runs` prints"


_EXAMPLES = {
    "list": "gearcase runs list minimal",
    "open": "gearcase runs open bench",
    "compare": "gearcase runs compare 1 5",
    "clean": "gearcase runs clean 5 --yes",
}


def json_argument(sub: argparse.ArgumentParser) -> None:
    """--json."""
    sub.add_argument("--json", action="store_true", help="print the results as JSON, for programs")


def quiet_argument(sub: argparse.ArgumentParser) -> None:
    """--quiet."""
    sub.add_argument("-q", "--quiet", action="store_true", help="print results, warnings and errors only")


def diagnose_arguments(sub: argparse.ArgumentParser) -> None:
    """A recording, its machine, healthy ones."""
    sub.add_argument(
        "run",
        metavar="RECORD",
        type=path,
        help=f"recording file, {RUN_HELP}",
    )
    sub.add_argument(
        "--machine",
        metavar="FILE",
        type=path,
        help="machine of the recording: a file with teeth, speed and sensors, or a scene",
    )
    sub.add_argument(
        "--baseline",
        metavar="RECORD",
        type=path,
        nargs="+",
        default=[],
        help="recordings of healthy machines to compare with; p-values need 5 or more",
    )
    sub.add_argument(
        "--window",
        metavar=("START", "END"),
        type=number,
        nargs=2,
        help="time window to analyse, s (default: the windows of the scene, or all)",
    )
    sub.add_argument(
        "--set",
        metavar="KEY=VALUE",
        dest="settings",
        action="append",
        default=[],
        help="change a setting of the diagnosis of a run, as in --set diagnosis.sensor=sensor_5; repeatable",
    )
    json_argument(sub)


def compare_arguments(sub: argparse.ArgumentParser) -> None:
    """Recordings, and what of them is shown."""
    sub.add_argument(
        "recordings",
        metavar="RECORD",
        type=path,
        nargs="+",
        help="2 to 10 recording files, or runs by folder, scene name or number; add a time window by its name or in s, "
        "as in bench@steady or bench@0.5:2.5",
    )
    sub.add_argument(
        "--machine",
        metavar="FILE",
        type=path,
        help="machine of the recordings: a file with teeth, speed and sensors, or a scene",
    )
    sub.add_argument("--sensor", metavar="NAME", help="sensor in the figures (default: that with the highest level)")
    sub.add_argument(
        "--axis", choices=("x", "y", "z"), help="axis of the sensor (default: that with the highest level)"
    )
    sub.add_argument(
        "--shaft",
        metavar="N",
        type=count,
        help="number of the shaft of the time-synchronous averages (default: that whose features differ most)",
    )
    sub.add_argument("--out", metavar="FOLDER", type=path, help="folder for figures and CSV (default: ./comparison)")


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
        return action_parser(actions, sub, name, words, _EXAMPLES[name])

    listing = action("list", "list the runs under ./runs, newest first")
    listing.add_argument("scene", metavar="SCENE", nargs="?", help="list only the runs of this scene")
    listing.add_argument("--json", action="store_true", default=argparse.SUPPRESS, help="print the list as JSON")
    action("open", "open the report of a run in the browser").add_argument(
        "run", metavar="RUN", type=path, help=RUN_HELP
    )
    compared = action("compare", "compare verdicts, settings and sensor levels of runs")
    compared.add_argument("runs", metavar="RUN", type=path, nargs="+", help=RUN_HELP)
    compared.add_argument("--json", action="store_true", default=argparse.SUPPRESS, help="print the table as JSON")
    clean = action("clean", "show which runs would be removed; with --yes remove them")
    clean.add_argument("runs", metavar="RUN", type=path, nargs="*", help=RUN_HELP)
    clean.add_argument("--older-than", metavar="DAYS", type=days, help="remove only runs older than this, days")
    clean.add_argument("--keep", metavar="N", type=count, help="keep the newest N runs of each scene")
    clean.add_argument("--yes", action="store_true", help="remove the runs (default: only list them)")


def export_arguments(sub: argparse.ArgumentParser) -> None:
    """A run and the format of the file."""
    _run_folder(sub)
    sub.add_argument("--to", dest="form", choices=("csv", "mat", "uff"), required=True, help="file format")
    sub.add_argument(
        "--out",
        metavar="FILE",
        type=path,
        help="file to write (default: response.csv, .mat or .uff in the result folder)",
    )


def orders_arguments(sub: argparse.ArgumentParser) -> None:
    """A run and the orders that are shown."""
    _run_folder(sub)
    sub.add_argument(
        "--shaft",
        metavar="N",
        type=count,
        help="number of the shaft whose speed is order 1 (default: the driven shaft)",
    )
    sub.add_argument(
        "--sensor", metavar="NAME", help="sensor to analyse (default: that of the diagnosis, or the first)"
    )
    sub.add_argument("--axis", choices=("x", "y", "z"), help="axis of the sensor (default: that of the diagnosis)")
    sub.add_argument(
        "--orders",
        metavar="K",
        type=positive,
        nargs="+",
        default=[],
        help="orders whose amplitudes are shown over speed (default: the mesh orders)",
    )
    sub.add_argument(
        "--revolutions", metavar="N", type=several, default=16, help="revolutions in a window, 2 or more (default 16)"
    )
    sub.add_argument("--campbell", action="store_true", help="add a Campbell diagram: natural frequencies over speed")
    sub.add_argument("--out", metavar="FOLDER", type=path, help="folder for the pictures (default: the result folder)")
    quiet_argument(sub)
