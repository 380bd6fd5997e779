"""Arguments of a scene, and of the studies that repeat one in variants."""

from __future__ import annotations

import argparse

from pipelines.border.argument_types import count, from_zero, path, picture, seconds, several, share
from pipelines.scene.presets import PRESETS
from pipelines.trade.axes import AXES


def scene_arguments(sub: argparse.ArgumentParser) -> None:
    """A scene, and what is changed in it."""
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
        help="mesh sizes, slices and time step; --set overrides it (default: the settings of the scene)",
    )


def work_arguments(sub: argparse.ArgumentParser) -> None:
    """A scene, and how its steps are built."""
    scene_arguments(sub)
    sub.add_argument("--processes", type=count, metavar="N", help="long steps built side by side (default 2)")
    sub.add_argument("-q", "--quiet", action="store_true", help="no progress")


def converge_arguments(sub: argparse.ArgumentParser) -> None:
    """What is refined, and how far."""
    work_arguments(sub)
    sub.add_argument("--over", choices=tuple(AXES), required=True, help="what is refined")
    sub.add_argument(
        "--levels",
        type=count,
        metavar="N",
        default=3,
        help="levels of refinement, one of them finer than the setting in use (default 3)",
    )
    sub.add_argument("--error", type=share, metavar="E", default=0.01, help="target error, as in 1%% (default)")
    sub.add_argument(
        "--out", type=picture, metavar="FILE", help="plot to write (default: convergence-<scene>-<axis>.png here)"
    )


def tradeoff_arguments(sub: argparse.ArgumentParser) -> None:
    """Wanted error and time."""
    work_arguments(sub)
    sub.add_argument("--error", type=share, metavar="E", default=0.02, help="name the cheapest within it (2%%)")
    sub.add_argument("--time", type=seconds, metavar="T", default=10.0, help="name the most accurate within it (10s)")
    sub.add_argument("--out", type=picture, metavar="FILE", help="plot to write (default: tradeoff-<scene>.png here)")


def starts_arguments(sub: argparse.ArgumentParser) -> None:
    """How many motions."""
    work_arguments(sub)
    sub.add_argument("--starts", type=several, metavar="N", default=8, help="motions, from 2 (default 8)")


def verify_arguments(sub: argparse.ArgumentParser) -> None:
    """Which claims, over how many seeds."""
    sub.add_argument("what", metavar="WHAT", choices=("rig",), help="rig: the study of the quay-crane hoist rig")
    sub.add_argument("--seeds", type=several, metavar="N", default=5, help="of the deviations, from 2 (default 5)")
    sub.add_argument("--preset", choices=PRESETS, default="standard", help="how finely it is computed (standard)")
    sub.add_argument("--out", metavar="FOLDER", type=path, help="write claims.md and claims.json there")
    sub.add_argument("--processes", type=count, metavar="N", help="long steps built side by side (default 2)")
    sub.add_argument("-q", "--quiet", action="store_true", help="no progress")


def detect_arguments(sub: argparse.ArgumentParser) -> None:
    """Damage, noise, and how many machines."""
    scene_arguments(sub)
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
