"""Arguments of `gearcase housing`."""

from __future__ import annotations

import argparse

from pipelines.border.argument_types import count, path, positive


def housing_arguments(sub: argparse.ArgumentParser) -> None:
    """Of `gearcase housing`."""
    sub.add_argument(
        "file",
        metavar="FILE",
        type=path,
        help="STEP, BREP, IGES, STL, a mesh, or matrices: .op4 .pch .mtx .sti .npz .h5",
    )
    sub.add_argument(
        "--scene", metavar="SCENE", type=path, help="propose the seats of its shafts, write the block for it"
    )
    sub.add_argument(
        "--unit", choices=("m", "cm", "mm", "um", "inch"), help="of the file (default: as it declares, or mm)"
    )
    sub.add_argument(
        "--solids", metavar="N", type=count, nargs="+", default=[], help="look for seats in these solids only"
    )
    sub.add_argument("--out", metavar="FOLDER", type=path, help="for what is written (default ./<file>-housing)")
    matrices = sub.add_argument_group("matrices of another program")
    matrices.add_argument("--mass", metavar="FILE", type=path, help="of the mass, where FILE holds the stiffness alone")
    matrices.add_argument(
        "--nodes", metavar="FILE", type=path, help="rows of number, x, y, z; GRID cards of Nastran; *NODE of Abaqus"
    )
    matrices.add_argument(
        "--equations",
        metavar="FILE",
        type=path,
        help="rows of node, axis (1-6, 0 modal); .mapping; EXTRN cards",
    )
    matrices.add_argument(
        "--units",
        choices=("kg-m-s", "t-mm-s", "kg-mm-ms", "kg-mm-s", "lbf-in-s"),
        default="kg-m-s",
        help="mass (lbf: the force), length and time of the matrices (default kg-m-s)",
    )
    matrices.add_argument("--keep", metavar="NODE", type=count, nargs="+", default=[], help="reduce to these nodes")
    matrices.add_argument(
        "--hold", metavar="NODE", type=count, nargs="+", default=[], help="nodes that the ground holds"
    )
    matrices.add_argument("--band", metavar="HZ", type=positive, default=2000.0, help="keep modes up to it (2000)")
