"""The command line of `gearcase`: its commands, their arguments and their help.

Only the standard library is imported, so that help appears at once.
"""

from __future__ import annotations

import argparse
import sys
from typing import NoReturn

from pipelines.border.argument_types import (
    count,
    days,
    from_zero,
    number,
    path,
    picture,
    positive,
    seconds,
    several,
    share,
    tilt,
)
from pipelines.dataset_arguments import dataset_arguments
from pipelines.finished_arguments import (
    compare_arguments,
    diagnose_arguments,
    export_arguments,
    orders_arguments,
)
from pipelines.housing_arguments import housing_arguments
from pipelines.scene.presets import PRESETS
from pipelines.trade.axes import AXES

PROLOGUE = """\
From gearbox geometry to sensor signals: finite-element mesh stiffness, reduced casing, multibody run, diagnosis.

A SCENE is the name of a shipped scene (minimal, bench, reducer, rig-missing-tooth, ...) or a path ending in .toml.
A RUN is a result folder, or the name of a scene whose newest result under ./runs is meant.
"""
EPILOGUE = """\
first steps:
  gearcase run minimal                        a whole run in seconds; opens nothing, names the report
  gearcase new my.toml --from bench           a commented scene to change
  gearcase check my.toml                      what follows from it, before anything is computed
  gearcase run my.toml                        signals, diagnosis and report under ./runs/my

More on a command: gearcase COMMAND --help
"""


class Parser(argparse.ArgumentParser):
    """Says what is wrong with an argument without printing the argument raw or at length."""

    def error(self, message: str) -> NoReturn:
        """Usage and the message on standard error; exit code 2."""
        from pipelines.border.shown import shown

        head, tail = message[:_MESSAGE_END], message[_MESSAGE_END:]
        if len(tail) > _MESSAGE_END:
            tail = f"...{tail[-_MESSAGE_END:]}"
        self.print_usage(sys.stderr)
        self.exit(2, f"{self.prog}: error: {shown(head)}{shown(tail)}\n")


_MESSAGE_END = 180  # characters at the front and at the end of a message on arguments: choices stand at its end


class Formatter(argparse.RawDescriptionHelpFormatter):
    """Keeps the line breaks of examples; a little wider than the default."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=30, width=110)


def parser() -> argparse.ArgumentParser:
    """The whole command line."""
    top = Parser(prog="gearcase", description=PROLOGUE, epilog=EPILOGUE, formatter_class=Formatter, allow_abbrev=False)
    top.add_argument("--version", action="store_true", help="print the version and end")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    for name, words, example, arguments in COMMANDS:
        sub = commands.add_parser(
            name,
            help=words,
            description=f"{words[0].upper()}{words[1:]}.",
            epilog=f"example:\n  {example}",
            formatter_class=Formatter,
            allow_abbrev=False,
        )
        arguments(sub)
        sub.add_argument("-v", "--verbose", action="store_true", help="log what is done; tracebacks of failures")
    return top


def _scene(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("scene", metavar="SCENE", type=path, help="name of a shipped scene, or a path ending in .toml")
    sub.add_argument(
        "--set",
        metavar="KEY=VALUE",
        dest="settings",
        action="append",
        default=[],
        help="change one value, as in --set stages.1.face_width_mm=32; repeatable; items count from 1",
    )
    sub.add_argument(
        "--preset",
        choices=PRESETS,
        help="how finely it is computed; --set counts more (default: as the scene says)",
    )


def _work(sub: argparse.ArgumentParser) -> None:
    _scene(sub)
    sub.add_argument("--processes", type=count, metavar="N", help="long steps built side by side (default 2)")
    sub.add_argument("-q", "--quiet", action="store_true", help="no progress")


def _gears(sub: argparse.ArgumentParser) -> None:
    _work(sub)
    sub.add_argument("--load", metavar="N", type=positive, help="force on the line of action (default: of the scene)")
    sub.add_argument(
        "--tilt",
        metavar="UM",
        type=tilt,
        default=0.0,
        help="approach at the +y end less that at -y; balanced: force at mid face; machine: of the loaded machine (0)",
    )
    sub.add_argument("--out", metavar="FILE", type=path, help="write the curves over the position: .csv or .nc")


def _casing(sub: argparse.ArgumentParser) -> None:
    _work(sub)
    sub.add_argument(
        "--error-check",
        action="store_true",
        help="compare frequencies and responses with the full model; costs about as much as the reduction",
    )
    sub.add_argument(
        "--export",
        metavar="FILE",
        type=path,
        action="append",
        default=[],
        help="write the reduced casing as .h5, .mat or .uff (modal test), or its modes as .vtu; repeatable",
    )
    sub.add_argument("--modes", metavar="N", type=count, default=20, help="rows of the table of modes (default 20)")


def _out(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--out", metavar="FOLDER", type=path, help="result folder instead of ./runs/<scene>/<timestamp>")


def _new(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("file", metavar="FILE", type=path, help="file to write, ending in .toml; never overwritten")
    sub.add_argument(
        "--from",
        metavar="SOURCE",
        type=path,
        dest="source",
        default="bench",
        help="a scene, or a gear unit in REXS: .rexs, .rexsj or .rexsz (default: bench)",
    )


def _run(sub: argparse.ArgumentParser) -> None:
    _work(sub)
    _out(sub)
    sub.add_argument("--no-control", action="store_true", help="leave out the healthy control and the diagnosis")
    sub.add_argument("--one-load", action="store_true", help="run the model of the load in the scene alone")
    sub.add_argument(
        "--seeds",
        metavar="N",
        type=count,
        default=0,
        help="compare seeds 1 to N of the deviations and error-free gears",
    )
    sub.add_argument(
        "--baseline",
        metavar="N",
        type=count,
        default=0,
        help="judge against N healthy machines with other deviations; p-values take 5 or more",
    )


def _modes(sub: argparse.ArgumentParser) -> None:
    _work(sub)
    sub.add_argument("--up-to", metavar="HZ", type=positive, default=10e3, help="highest frequency (default 10000)")
    sub.add_argument("--cycle", metavar="C", type=number, help="mesh cycle of stage 1 (default: that of the start)")
    sub.add_argument(
        "--speed",
        type=number,
        default=0.0,
        metavar="RPM",
        help="motor speed: losses, gyroscopic moments (default 0)",
    )


def _converge(sub: argparse.ArgumentParser) -> None:
    _work(sub)
    sub.add_argument("--over", choices=tuple(AXES), required=True, help="what is refined")
    sub.add_argument("--levels", type=count, metavar="N", default=3, help="levels, one finer than in use (default 3)")
    sub.add_argument("--error", type=share, metavar="E", default=0.01, help="wanted error, as in 1%% (default)")
    sub.add_argument("--out", type=picture, metavar="FILE", help="plot to write (convergence-<scene>-<what>.png here)")


def _tradeoff(sub: argparse.ArgumentParser) -> None:
    _work(sub)
    sub.add_argument("--error", type=share, metavar="E", default=0.02, help="name the cheapest within it (2%%)")
    sub.add_argument("--time", type=seconds, metavar="T", default=10.0, help="name the most accurate within it (10s)")
    sub.add_argument("--out", type=picture, metavar="FILE", help="plot to write (default: tradeoff-<scene>.png here)")


def _starts(sub: argparse.ArgumentParser) -> None:
    _work(sub)
    sub.add_argument("--starts", type=several, metavar="N", default=8, help="motions, from 2 (default 8)")


def _verify(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("what", metavar="WHAT", choices=("rig",), help="rig: the study of the quay-crane hoist rig")
    sub.add_argument("--seeds", type=several, metavar="N", default=5, help="of the deviations, from 2 (default 5)")
    sub.add_argument("--preset", choices=PRESETS, default="standard", help="how finely it is computed (standard)")
    sub.add_argument("--out", metavar="FOLDER", type=path, help="write claims.md and claims.json there")
    sub.add_argument("--processes", type=count, metavar="N", help="long steps built side by side (default 2)")
    sub.add_argument("-q", "--quiet", action="store_true", help="no progress")


def _simulate(sub: argparse.ArgumentParser) -> None:
    _work(sub)
    _out(sub)


def _inspect(sub: argparse.ArgumentParser) -> None:
    _work(sub)
    sub.add_argument("--out", metavar="FOLDER", type=path, default=".", help="folder for the pictures (default: here)")
    sub.add_argument("--stage", type=count, metavar="N", default=1, help="gear stage to show (default 1)")
    sub.add_argument("--position", type=number, metavar="C", help="one mesh cycle to show instead of a film")
    sub.add_argument("--frames", type=count, metavar="N", default=17, help="pictures of the film (17; 1: a still)")
    sub.add_argument("--stress", action="store_true", help="instead, von Mises stress of the loaded teeth: PNG")
    sub.add_argument(
        "--mesh",
        metavar="FILE",
        type=path,
        help="instead, hexahedra of the loaded teeth: .vtu, .inp, .msh or .bdf",
    )
    sub.add_argument("--screen", action="store_true", help="instead, a window with a slider for the position")
    sub.add_argument(
        "--casing-mode",
        type=count,
        metavar="N",
        help="instead, natural mode N of the casing: PNG, GIF and HTML",
    )


def _cache(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("action", choices=("info", "verify", "clear"), nargs="?", default="info", help="default: info")
    sub.add_argument(
        "--older-than",
        metavar="DAYS",
        type=days,
        default=0.0,
        help="clear only what was not used lately",
    )


def _campaign(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("plan", metavar="PLAN", type=path, help="file of the campaign, ending in .toml")
    sub.add_argument("--out", metavar="FOLDER", type=path, help="data set instead of ./campaigns/<plan>")
    sub.add_argument("--dry-run", action="store_true", help="say what it would simulate, and what that costs")
    sub.add_argument("--processes", type=count, metavar="N", help="scenes at the same time (default: all cores)")
    where = sub.add_mutually_exclusive_group()
    where.add_argument("--scheduler", metavar="ADDRESS", help="Dask scheduler to use, or the file that it wrote")
    where.add_argument("--cluster", action="store_true", help="a Dask scheduler of its own, with a dashboard")
    sub.add_argument("--retry-failed", action="store_true", help="simulate again what failed")
    sub.add_argument("-q", "--quiet", action="store_true", help="no progress")


def _detect(sub: argparse.ArgumentParser) -> None:
    _scene(sub)
    sub.add_argument(
        "--over",
        metavar="KEY=VALUES",
        action="append",
        default=[],
        help="values of a key of the scene, from:to:step or a,b,c; repeatable (default: the fault as it is)",
    )
    sub.add_argument("--seeds", metavar="N", type=count, default=10, help="damaged machines per value (default 10)")
    sub.add_argument("--baseline", metavar="N", type=count, default=8, help="healthy machines to compare with (8)")
    sub.add_argument("--healthy", metavar="N", type=count, default=20, help="others, for the false alarms (20)")
    sub.add_argument(
        "--noise",
        metavar="RMS",
        type=from_zero,
        nargs="+",
        default=[],
        help="sensor noise, m/s2 rms; more levels take no more simulations (default: that of the scene)",
    )
    sub.add_argument("--out", metavar="FOLDER", type=path, help="instead of ./campaigns/detect-<scene>")
    sub.add_argument("--dry-run", action="store_true", help="say what it would simulate, and what that costs")
    sub.add_argument("--processes", type=count, metavar="N", help="scenes at the same time (default: all cores)")
    sub.add_argument("-q", "--quiet", action="store_true", help="no progress")


FINISHED = ("compare", "diagnose", "export", "orders")  # commands that read a finished run, in a room of their own
STUDIES = ("converge", "detect", "starts", "tradeoff", "verify")  # those that repeat a scene in variants, in another
COMMANDS = (  # name, of the module too; one line; example; arguments
    ("new", "write a commented scene file to change", "gearcase new my.toml --from bench", _new),
    ("check", "validate a scene and print what follows from it", "gearcase check rig-missing-tooth", _scene),
    (
        "explain",
        "say what a run would build, reuse, and why",
        "gearcase explain bench --set load.torque_N_m=80",
        _scene,
    ),
    ("gears", "stiffness and load share of each pair, healthy and faulty", "gearcase gears bench", _gears),
    ("housing", "bores and seats in a housing's file", "gearcase housing box.step --scene bench", housing_arguments),
    ("casing", "build the casing and print its check-up", "gearcase casing rig-healthy", _casing),
    (
        "modes",
        "linearise the loaded machine and print its frequencies",
        "gearcase modes rig-healthy --up-to 5000",
        _modes,
    ),
    (
        "converge",
        "refine one thing and say how far the answer is off",
        "gearcase converge minimal --over step",
        _converge,
    ),
    (
        "tradeoff",
        "measure what every model and setting costs and gains",
        "gearcase tradeoff minimal --error 2%",
        _tradeoff,
    ),
    (
        "starts",
        "repeat a motion from other starts; mean and spread of levels",
        "gearcase starts minimal --starts 8",
        _starts,
    ),
    (
        "verify",
        "put the claims of the rig's study to the test: 40 simulations",
        "gearcase verify rig --out claims",
        _verify,
    ),
    (
        "simulate",
        "run the machine and write response.nc, no control, no report",
        "gearcase simulate minimal",
        _simulate,
    ),
    (
        "diagnose",
        "what is damaged in a recording; the lines of a fault in a finished run",
        "gearcase diagnose record.csv --machine bench.toml --baseline healthy1.csv healthy2.csv",
        diagnose_arguments,
    ),
    (
        "compare",
        "lay recordings side by side: table of features, spectra, averages",
        "gearcase compare bench@lifting bench@lowering",
        compare_arguments,
    ),
    ("run", "everything: simulation, healthy control, diagnosis, report", "gearcase run rig-missing-tooth", _run),
    ("campaign", "simulate the scenes of a plan into one labelled data set", "gearcase campaign plan.toml", _campaign),
    (
        "dataset",
        "count, check or export what a campaign made; features of it",
        "gearcase dataset info campaigns/plan",
        dataset_arguments,
    ),
    (
        "detect",
        "simulate how probably damage is found, over its size, noise and sensors",
        "gearcase detect bench --over faults.1.depth_mm=0.5:3:0.5 --noise 0.01 0.3",
        _detect,
    ),
    (
        "orders",
        "waterfall, order cuts and natural frequencies of a run-up",
        "gearcase orders reducer",
        orders_arguments,
    ),
    (
        "inspect",
        "write pictures of a gear pair with its curve and of the casing",
        "gearcase inspect rig-healthy",
        _inspect,
    ),
    (
        "export",
        "write the signals of a run as CSV, MATLAB or UFF file",
        "gearcase export rig-missing-tooth --to mat",
        export_arguments,
    ),
    ("cache", "show, verify or clear the store of finished steps", "gearcase cache info", _cache),
)
