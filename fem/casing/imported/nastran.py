"""Matrices, nodes and equations of Nastran files (package pyyeti).

GRID positions are transformed to the basic frame by their field CP. The field CD names the frame of the equations of a
node; its directions are the columns of F, u_basic = F u_node. In cylindrical and spherical frames they depend on the
position of the node. EXTRN cards of a superelement (EXTSEOUT) name the equations of its matrices.

Reference: MSC Nastran Quick Reference Guide, entries GRID, CORD2R, CORD2C, CORD2S, EXTRN and DMIG.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy.sparse as sp

from fem.casing.imported.imported_body import MatrixError

SUFFIXES = (".bdf", ".dat", ".nas", ".blk", ".pch", ".asm")  # of files with GRID or EXTRN cards


def output4(path: Path) -> dict[str, sp.csr_matrix]:
    """Matrices of an OUTPUT4 file, ASCII or binary, by their names in lower case."""
    from pyyeti.nastran import op4

    return {name.lower(): sp.csr_matrix(m) for name, m in op4.read(str(path), sparse=None).items()}


def punched(path: Path) -> tuple[dict[str, sp.coo_matrix], np.ndarray]:
    """Square matrices of DMIG cards by their names in lower case, and node and axis (n, 2) of their equations.

    ROWSX (row, n) of an export of gearcase is found as `rows`.

    Raises
    ------
    ForeignError : no square matrix
    """
    from pyyeti.nastran import bulk

    tables = bulk.rddmig(str(path), expanded=False, square=True)
    square = {name.lower(): table for name, table in tables.items() if table.shape[0] == table.shape[1]}
    if not square:
        raise MatrixError(f"{path.name} holds no square DMIG matrix; export KAAX and MAAX (PARAM,EXTOUT,DMIGPCH)")
    every = sorted(set().union(*(set(table.index) for table in square.values())))
    rows = {"rows": tables["rowsx"]} if "rowsx" in tables else {}
    matrices = {
        name: sp.coo_matrix(table.reindex(index=None if name in rows else every, columns=every, fill_value=0.0))
        for name, table in (square | rows).items()
    }
    return matrices, np.array(every, int).reshape(-1, 2)


def superelement_equations(path: Path) -> np.ndarray:
    """Node and axis (n, 2) of every equation, of EXTRN cards; axis 0 for the modal coordinates of scalar points.

    Raises
    ------
    ForeignError : no EXTRN card
    """
    from pyyeti.nastran import bulk

    if "EXTRN" not in path.read_text(encoding="latin-1").upper():
        raise MatrixError(f"{path.name} has no EXTRN card, which names the equations of a superelement (EXTSEOUT)")
    return np.asarray(bulk.rdextrn(str(path)), int)


def grid_points(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Number and position in the basic frame (k, 4) of every node, and the frame F (k, 3, 3) of its motion.

    Raises
    ------
    ForeignError : no GRID card, or coordinate systems that are not defined in the file by CORD2R, CORD2C or CORD2S
    """
    from pyyeti.nastran import bulk, n2p

    cards = bulk.rdgrids(str(path))
    if cards is None:
        raise MatrixError(f"{path.name} has no GRID cards")
    known = {0, *bulk.rdcord2cards(str(path))}
    if unknown := set(np.unique(cards[:, [1, 5]]).astype(int)) - known:
        raise MatrixError(
            f"{path.name}: nodes use the coordinate system {min(unknown)}, which no CORD2R, CORD2C or CORD2S card of "
            "the file defines; write it as one of these, or export the nodes in the basic system"
        )
    table, _ = bulk.bulk2uset(str(path))
    rows = table[["x", "y", "z"]].to_numpy().reshape(-1, 6, 3)  # position, (frame, kind, 0), origin, directions
    numbers = table.index.get_level_values("id").to_numpy()[::6]
    places = rows[:, 0]
    frames = np.broadcast_to(np.eye(3), (len(places), 3, 3)).copy()
    if (local := rows[:, 1, 0] != 0).any():  # rigid motions are given in the frame of each node
        motions = n2p.rbgeom_uset(table[np.repeat(local, 6)]).reshape(-1, 6, 6)
        frames[local] = motions[:, :3, :3].transpose(0, 2, 1)
    return np.column_stack([numbers, places]), frames
