"""Arguments of a scene, and of the studies that repeat one in variants."""

from __future__ import annotations

import argparse

from pipelines.cli.finished_arguments import quiet_argument
from pipelines.io.argument_types import count, from_zero, path, picture, seconds, several, share
from pipelines.scene.presets import PRESETS
from pipelines.studies.trade.axes import AXES


def scene_arguments(sub: argparse.ArgumentParser) -> None:
    """A scene, and what is changed in it."""
    sub.add_argument("scene", metavar="SCENE", type=path, help="name of a shipped scene, or a path that ends in .toml")
    sub.add_argument(
        "--set",
        metavar="KEY=VALUE",
        dest="settings",
        action="append",
        default=[],
        help="change one value of the scene, as in --set stages.1.face_width_mm=32; "
        "items of a list are counted from 1; repeatable",
    )
    sub.add_argument(
        "--preset",
        choices=PRESETS,
        help="accuracy of meshes and time step, from coarse (draft) to fine (reference); --set overrides it (default: "
        "as in the scene)",
    )
    quiet_argument(sub)


def work_arguments(sub: argparse.ArgumentParser) -> None:
    """A scene, and how its steps are built."""
    scene_arguments(sub)
    sub.add_argument(
        "--processes", type=count, metavar="N", help="number of steps that are computed at the same time (default 2)"
    )


def converge_arguments(sub: argparse.ArgumentParser) -> None:
    """What is refined, and how far."""
    work_arguments(sub)
    sub.add_argument(
        "--over",
        choices=tuple(AXES),
        required=True,
        help="setting to refine: element size of the gears, slices of the face, positions in the mesh cycle, element "
        "size or number of modes of the casing, element length of the shafts, or time step",
    )
    sub.add_argument(
        "--levels",
        type=count,
        metavar="N",
        default=3,
        help="number of values of the setting: one finer than in the scene, that of the scene, and coarser ones "
        "(default 3)",
    )
    sub.add_argument(
        "--error", type=share, metavar="E", default=0.01, help="target error, a fraction or as in 1%% (default 1%%)"
    )
    sub.add_argument(
        "--out",
        type=picture,
        metavar="FILE",
        help="plot, .png, .svg or .pdf (default: ./convergence-<scene>-<setting>.png)",
    )


def tradeoff_arguments(sub: argparse.ArgumentParser) -> None:
    """Target error and time."""
    work_arguments(sub)
    sub.add_argument(
        "--error",
        type=share,
        metavar="E",
        default=0.02,
        help="print the least expensive choice within this error, a fraction or as in 2%% (default 2%%)",
    )
    sub.add_argument(
        "--time",
        type=seconds,
        metavar="T",
        default=10.0,
        help="print the most accurate choice within this time, s (default 10)",
    )
    sub.add_argument(
        "--out", type=picture, metavar="FILE", help="plot, .png, .svg or .pdf (default: ./tradeoff-<scene>.png)"
    )


def starts_arguments(sub: argparse.ArgumentParser) -> None:
    """How many motions."""
    work_arguments(sub)
    sub.add_argument(
        "--starts", type=several, metavar="N", default=8, help="number of initial states, 2 or more (default 8)"
    )


def verify_arguments(sub: argparse.ArgumentParser) -> None:
    """Which claims, over how many seeds."""
    sub.add_argument(
        "what", metavar="WHAT", choices=("rig",), help="rig: the study of the quay-crane hoist rig; there is no other"
    )
    sub.add_argument(
        "--seeds", type=several, metavar="N", default=5, help="seeds of the gear deviations, 2 or more (default 5)"
    )
    sub.add_argument(
        "--preset",
        choices=PRESETS,
        default="standard",
        help="accuracy of meshes and time step, from coarse (draft) to fine (reference) (default standard)",
    )
    sub.add_argument(
        "--out", metavar="FOLDER", type=path, help="folder for claims.md and claims.json (default: print only)"
    )
    sub.add_argument(
        "--processes", type=count, metavar="N", help="number of steps that are computed at the same time (default 2)"
    )
    quiet_argument(sub)


def detect_arguments(sub: argparse.ArgumentParser) -> None:
    """Damage, noise, and how many machines."""
    scene_arguments(sub)
    sub.add_argument(
        "--over",
        metavar="KEY=VALUES",
        action="append",
        default=[],
        help="values of a key of the scene, as KEY=from:to:step or KEY=a,b,c; repeatable (default: the fault as in the "
        "scene)",
    )
    sub.add_argument(
        "--seeds", metavar="N", type=count, default=10, help="damaged machines for each value (default 10)"
    )
    sub.add_argument(
        "--baseline", metavar="N", type=count, default=8, help="healthy machines to compare with (default 8)"
    )
    sub.add_argument(
        "--healthy",
        metavar="N",
        type=count,
        default=20,
        help="further healthy machines, for the rate of false alarms (default 20)",
    )
    sub.add_argument(
        "--noise",
        metavar="RMS",
        type=from_zero,
        nargs="+",
        default=[],
        help="sensor noise, m/s2 rms; several values need no further simulations (default: that of the scene)",
    )
    sub.add_argument("--out", metavar="FOLDER", type=path, help="result folder (default: ./campaigns/detect-<scene>)")
    sub.add_argument(
        "--dry-run", action="store_true", help="print number of runs, time and disk space, and simulate nothing"
    )
    sub.add_argument(
        "--processes", type=count, metavar="N", help="scenes simulated at the same time (default: number of cores)"
    )
