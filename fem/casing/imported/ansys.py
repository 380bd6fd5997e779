"""Matrices of Ansys: Harwell-Boeing files of the command HBMAT, and the mapping file next to them.

Five header lines give the counts of lines and the Fortran formats; the column pointers, the rows and the values follow.
Type RSA holds one triangle of a symmetric matrix. A right-hand side may follow and is not read.

Reference: Duff, Grimes & Lewis (1992), Users' Guide for the Harwell-Boeing Sparse Matrix Collection, TR/PA/92/86.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from fem.casing.imported.imported_body import MatrixError

AXES = {"UX": 1, "UY": 2, "UZ": 3, "ROTX": 4, "ROTY": 5, "ROTZ": 6}


def harwell_boeing(path: Path) -> sp.coo_matrix:
    """The matrix (n, n) of an assembled real ASCII file.

    Raises
    ------
    ForeignError : the file has another type, or is truncated
    """
    lines = path.read_text(encoding="latin-1").splitlines()
    if len(lines) < 5 or not re.match(r"[A-Z]{3}\s", lines[2].upper()):
        raise MatrixError(f"{path.name} is no Harwell-Boeing file in ASCII; write it by HBMAT,Fname,Ext,,ASCII,STIFF")
    counts = [int(word) for word in lines[1].split()]
    kind, (rows, columns, entries) = lines[2][:3].upper(), (int(word) for word in lines[2][3:].split()[:3])
    if kind not in ("RSA", "RUA"):
        raise MatrixError(
            f"{path.name} is of the type {kind}; real assembled matrices (RSA, RUA) are read: no damping by HBMAT"
        )
    start = 5 if len(counts) > 4 and counts[4] else 4
    formats = re.findall(r"(\d+)[IEDFG](\d+)", lines[3].upper())
    found = []
    for (_, width), count in zip(formats, counts[1:4], strict=False):
        found.append(_fields(lines[start : start + count], int(width)))
        start += count
    pointers, indices, values = (np.array(one, float) for one in found)
    if len(pointers) != columns + 1 or len(indices) != entries or len(values) != entries:
        raise MatrixError(
            f"{path.name} is cut off: it holds {len(values)} of {entries} values of {columns} columns. Export it again"
        )
    packed = sp.csc_matrix((values, indices.astype(int) - 1, pointers.astype(int) - 1), shape=(rows, columns))
    packed.check_format(full_check=True)  # with wrong indices SciPy accesses memory out of bounds
    matrix = packed.tocoo()
    if kind == "RUA":
        return matrix
    return sp.coo_matrix(matrix + matrix.T - sp.diags_array(matrix.diagonal()))


def _fields(lines: Sequence[str], width: int) -> list[str]:
    """The numbers in lines of fixed-width fields, which may lack spaces between them.

    SciPy writes narrower fields than it states, with spaces.
    """
    fields = [line[at : at + width] for line in lines for at in range(0, len(line.rstrip()), width)]
    if any(" " in one.strip() for one in fields):
        fields = " ".join(lines).split()
    return [one.upper().replace("D", "E") for one in fields]


def mapped_equations(path: Path) -> np.ndarray:
    """Node and axis (n, 2) of every equation, of a file .mapping with rows of equation, node and UX, UY, ... ROTZ.

    Raises
    ------
    ForeignError : unknown axes (temperatures, pressures), or missing equations
    """
    rows = [line.split() for line in path.read_text(encoding="latin-1").splitlines()]
    rows = [row for row in rows if len(row) == 3 and row[0].isdecimal() and row[1].isdecimal()]
    if unknown := {row[2].upper() for row in rows} - set(AXES):
        raise MatrixError(
            f"{path.name} has the unknowns {', '.join(sorted(unknown))}; only "
            f"{', '.join(AXES)} are read. Export a structural model"
        )
    found = np.array(sorted((int(row[0]), int(row[1]), AXES[row[2].upper()]) for row in rows)).reshape(-1, 3)
    if not len(found) or (found[:, 0] != np.arange(1, len(found) + 1)).any():
        raise MatrixError(f"{path.name} does not number the equations from 1 without gaps; export it again")
    return found[:, 1:]
