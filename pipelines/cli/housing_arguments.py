"""Arguments of `gearcase housing` and `gearcase casing`."""

from __future__ import annotations

import argparse

from pipelines.cli.finished_arguments import json_argument
from pipelines.cli.study_arguments import work_arguments
from pipelines.io.argument_types import count, path, positive


def housing_arguments(sub: argparse.ArgumentParser) -> None:
    """Of `gearcase housing`."""
    sub.add_argument(
        "file",
        metavar="FILE",
        type=path,
        help="CAD file (STEP, BREP, IGES, STL), mesh, or matrices (.op4 .pch .mtx .sti .npz .h5)",
    )
    sub.add_argument(
        "--scene",
        metavar="SCENE",
        type=path,
        help="choose the bores for the bearings of this scene, and write the table [casing.housing] for it",
    )
    sub.add_argument(
        "--unit",
        choices=("m", "cm", "mm", "um", "inch"),
        help="unit of length of the file (default: the declared one, or mm)",
    )
    sub.add_argument(
        "--solids",
        metavar="N",
        type=count,
        nargs="+",
        default=[],
        help="numbers of the solids whose bores may be chosen (default: all)",
    )
    sub.add_argument("--out", metavar="FOLDER", type=path, help="result folder (default: ./<file>-housing)")
    matrices = sub.add_argument_group("matrices of another program")
    matrices.add_argument(
        "--mass", metavar="FILE", type=path, help="mass matrix, if FILE holds the stiffness matrix only"
    )
    matrices.add_argument(
        "--nodes",
        metavar="FILE",
        type=path,
        help="file with the node coordinates: rows of number, x, y, z; GRID cards of Nastran; *NODE of Abaqus",
    )
    matrices.add_argument(
        "--equations",
        metavar="FILE",
        type=path,
        help="file with the order of the equations: rows of node and axis (1 to 6; 0: modal); .mapping of Ansys; EXTRN "
        "cards of Nastran",
    )
    matrices.add_argument(
        "--units",
        choices=("kg-m-s", "t-mm-s", "kg-mm-ms", "kg-mm-s", "lbf-in-s"),
        default="kg-m-s",
        help="units in the matrices: mass (lbf: force), length and time (default kg-m-s)",
    )
    matrices.add_argument(
        "--keep",
        metavar="NODE",
        type=count,
        nargs="+",
        default=[],
        help="reduce the matrices to these nodes, and write the reduced matrices",
    )
    matrices.add_argument(
        "--hold", metavar="NODE", type=count, nargs="+", default=[], help="nodes that are fixed to the ground"
    )
    matrices.add_argument(
        "--band",
        metavar="HZ",
        type=positive,
        default=2000.0,
        help="upper frequency of the reduced matrices, Hz (default 2000)",
    )


def casing_arguments(sub: argparse.ArgumentParser) -> None:
    """Of `gearcase casing`."""
    work_arguments(sub)
    sub.add_argument(
        "--error-check",
        action="store_true",
        help="compare frequencies and responses with the model before reduction; takes about as long as the reduction",
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
        help="write frequency responses (m/s2/N, CSV and PNG). The force acts at the first POINT in its axis, as in "
        "bearing_1:z; the others respond (default: all sensors)",
    )
    sub.add_argument(
        "--out",
        metavar="FOLDER",
        type=path,
        help="folder for the frequency responses of --response (default: the working folder)",
    )
    sub.add_argument("--modes", metavar="N", type=count, default=20, help="number of modes in the table (default 20)")
    json_argument(sub)
