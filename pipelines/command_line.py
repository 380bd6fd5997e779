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
    mode_number,
    number,
    path,
    picture,
    positive,
    tilt,
)
from pipelines.dataset_arguments import dataset_arguments
from pipelines.finished_arguments import (
    compare_arguments,
    diagnose_arguments,
    export_arguments,
    json_argument,
    orders_arguments,
    runs_arguments,
)
from pipelines.housing_arguments import housing_arguments
from pipelines.study_arguments import (
    converge_arguments,
    detect_arguments,
    scene_arguments,
    starts_arguments,
    tradeoff_arguments,
    verify_arguments,
    work_arguments,
)

PROLOGUE = """\
From gearbox geometry to sensor signals: finite-element mesh stiffness, reduced casing, multibody run, diagnosis.

A SCENE is the name of a shipped scene (minimal, bench, reducer, rig-missing-tooth, ...) or a path ending in .toml.
A RUN is a result folder, the name of a scene for its newest result under ./runs, or a number in `gearcase runs`.
"""
EPILOGUE = """\
first steps:
  gearcase run minimal                        a whole run in seconds; opens nothing, names the report
  gearcase new my.toml --from bench           a commented scene to change
  gearcase check my.toml                      what follows from it, before anything is computed
  gearcase run my.toml                        signals, diagnosis and report under ./runs/my

More on a command: gearcase COMMAND --help
"""


SHELLS = ("bash", "zsh", "tcsh")  # that can be completed


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


def _check(sub: argparse.ArgumentParser) -> None:
    scene_arguments(sub)
    json_argument(sub)


def _gears(sub: argparse.ArgumentParser) -> None:
    work_arguments(sub)
    sub.add_argument(
        "--torque",
        metavar="N_M",
        type=positive,
        nargs="+",
        help="torques on the pinion of each pair, N m, as in --torque 50 100 200 (default: of the scene)",
    )
    sub.add_argument(
        "--tilt",
        metavar="UM",
        type=tilt,
        default=0.0,
        help="approach at the +y end less that at -y; balanced: force at mid face; machine: of the loaded machine (0)",
    )
    sub.add_argument("--out", metavar="FILE", type=path, help="write the curves over the position: .csv or .nc")
    sub.add_argument(
        "--plot",
        metavar="FILE",
        type=picture,
        help="write transmission error (um) over the mesh cycle and its orders, before and after modifications: .png, "
        ".svg or .pdf (default: none)",
    )
    json_argument(sub)


def _casing(sub: argparse.ArgumentParser) -> None:
    work_arguments(sub)
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
        help="write the reduced matrices as .h5, .mat, .npz, .mtx, .op4 or .pch, a modal model as .uff, or the "
        "modes on the mesh as .vtu; repeatable",
    )
    sub.add_argument(
        "--response",
        metavar="POINT",
        nargs="+",
        default=[],
        help="acceleration per force at a point and axis, as in bearing_1:z, over frequency: CSV and PNG here; "
        "further POINTs respond (default: all sensors)",
    )
    sub.add_argument("--modes", metavar="N", type=count, default=20, help="rows of the table of modes (default 20)")
    json_argument(sub)


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
    work_arguments(sub)
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
    work_arguments(sub)
    sub.add_argument("--up-to", metavar="HZ", type=positive, default=10e3, help="highest frequency (default 10000)")
    sub.add_argument("--cycle", metavar="C", type=number, help="mesh cycle of stage 1 (default: that of the start)")
    sub.add_argument(
        "--speed",
        type=number,
        default=0.0,
        metavar="RPM",
        help="motor speed: losses, gyroscopic moments (default 0)",
    )
    json_argument(sub)


def _simulate(sub: argparse.ArgumentParser) -> None:
    work_arguments(sub)
    _out(sub)


def _inspect(sub: argparse.ArgumentParser) -> None:
    work_arguments(sub)
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
        type=mode_number,
        metavar="N",
        help="instead, natural mode N of the casing: PNG, GIF and HTML; all: one PNG of all modes in its band",
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


def _schema(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--out", metavar="FILE", type=path, help="file to write instead")


def _completion(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("shell", metavar="SHELL", choices=SHELLS, help=f"one of {', '.join(SHELLS)}")
    sub.set_defaults(whole_parser=parser)  # what is completed


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


FINISHED = (
    "compare",
    "diagnose",
    "export",
    "orders",
    "runs",
)  # commands that read a finished run, in a room of their own
STUDIES = ("converge", "detect", "starts", "tradeoff", "verify")  # those that repeat a scene in variants, in another
COMMANDS = (  # name, of the module too; one line; example; arguments
    ("new", "write a commented scene file to change", "gearcase new my.toml --from bench", _new),
    ("check", "validate a scene and print what follows from it", "gearcase check rig-missing-tooth", _check),
    (
        "explain",
        "say what a run would build, reuse, and why",
        "gearcase explain bench --set load.torque_N_m=80",
        scene_arguments,
    ),
    (
        "gears",
        "stiffness and load share of each pair, healthy and faulty",
        "gearcase gears pair --torque 50 100 --plot te.png",
        _gears,
    ),
    ("housing", "bores and seats in a housing's file", "gearcase housing box.step --scene bench", housing_arguments),
    (
        "casing",
        "reduce the casing: modes, check-up, frequency responses, matrices to export",
        "gearcase casing rig-healthy --response bearing_1:z --export casing.npz",
        _casing,
    ),
    (
        "modes",
        "linearise the loaded machine and print its frequencies",
        "gearcase modes rig-healthy --up-to 5000",
        _modes,
    ),
    (
        "converge",
        "refine one setting and estimate the discretisation error",
        "gearcase converge minimal --over step",
        converge_arguments,
    ),
    (
        "tradeoff",
        "measure what every model and setting costs and gains",
        "gearcase tradeoff minimal --error 2%",
        tradeoff_arguments,
    ),
    (
        "starts",
        "repeat a motion from other starts; mean and spread of levels",
        "gearcase starts minimal --starts 8",
        starts_arguments,
    ),
    (
        "verify",
        "put the claims of the rig's study to the test: 40 simulations",
        "gearcase verify rig --out claims",
        verify_arguments,
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
        detect_arguments,
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
        "runs",
        "list the finished runs; open, compare or remove them",
        "gearcase runs clean --older-than 30 --keep 3",
        runs_arguments,
    ),
    (
        "export",
        "write the signals of a run as CSV, MATLAB or UFF file",
        "gearcase export rig-missing-tooth --to mat",
        export_arguments,
    ),
    ("schema", "print the JSON schema of scenes, for editors", "gearcase schema --out scene.schema.json", _schema),
    ("completion", "print what a shell needs to complete commands", "gearcase completion bash", _completion),
    ("cache", "show, verify or clear the store of finished steps", "gearcase cache info", _cache),
)
