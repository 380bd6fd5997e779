"""Arguments of `gearcase gears` and `gearcase inspect`."""

from __future__ import annotations

import argparse

from pipelines.cli.finished_arguments import json_argument
from pipelines.cli.study_arguments import work_arguments
from pipelines.io.argument_types import count, mode_number, number, path, picture, positive, tilt


def gears_arguments(sub: argparse.ArgumentParser) -> None:
    """Of `gearcase gears`."""
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
        help="misalignment of the flanks over the face width, um, positive if they are closer at the +y end; or "
        "balanced: the misalignment that centres the load; or machine: that in the loaded machine (default 0)",
    )
    sub.add_argument(
        "--out",
        metavar="FILE",
        type=path,
        help="write the curves to this file, .csv or .nc: a row for each state and position; position 0 is contact of "
        "the tooth at the pitch point; stiffness, transmission error at the force and without load (no_load_error), "
        "tilt; load share and largest Hertz pressure of each tooth pair, +0 that of the tooth, +1 the next one",
    )
    sub.add_argument(
        "--plot",
        metavar="FILE",
        type=picture,
        help="plot the transmission error over the mesh cycle and its orders, with and without modifications, and "
        "while damaged teeth are in mesh, to this file: .png, .svg or .pdf",
    )
    json_argument(sub)


def inspect_arguments(sub: argparse.ArgumentParser) -> None:
    """Of `gearcase inspect`."""
    work_arguments(sub)
    sub.add_argument(
        "--out", metavar="FOLDER", type=path, default=".", help="folder for the pictures (default: the working folder)"
    )
    sub.add_argument("--stage", type=count, metavar="N", default=1, help="gear stage to show (default 1)")
    sub.add_argument(
        "--torque", metavar="N_M", type=positive, help="torque on the pinion of this stage, N m (default: of the scene)"
    )
    sub.add_argument(
        "--position",
        type=number,
        metavar="C",
        help="show one position in mesh, in mesh cycles (default: a film over one mesh cycle)",
    )
    sub.add_argument(
        "--frames", type=count, metavar="N", default=17, help="pictures in the film; 1 gives a still (default 17)"
    )
    sub.add_argument(
        "--stress", action="store_true", help="show the von Mises stress of the loaded teeth instead (PNG)"
    )
    sub.add_argument(
        "--mesh",
        metavar="FILE",
        type=path,
        help="write the hexahedral mesh of the loaded teeth instead, .vtu, .inp, .msh or .bdf",
    )
    sub.add_argument("--screen", action="store_true", help="open a window with a slider for the position instead")
    sub.add_argument(
        "--casing-mode",
        type=mode_number,
        metavar="N",
        help="show natural mode N of the casing instead (PNG, GIF and HTML); all: one PNG of all modes "
        "up to casing.band_Hz",
    )
