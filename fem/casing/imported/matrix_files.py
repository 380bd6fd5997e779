"""Readers of imported matrices. The suffix of the file selects the format:

.op4   Nastran OUTPUT4, ASCII or binary (package pyyeti); no map of equations
.pch   Nastran punch file of DMIG, which names node and axis of each equation (package pyyeti)
.mtx, .mmf  Matrix Market (Ansys *EXPORT,,MMF); or Abaqus *MATRIX GENERATE, rows of node, axis, node, axis, value
       (FORMAT=MATRIX INPUT) or of row, column, value (COORDINATE)
.matrix, .hb, .rsa  Harwell-Boeing (Ansys HBMAT); the file .mapping names node and axis of each equation
.sti   CalculiX (with .mas and .dof next to it)
.npz   NumPy: arrays stiffness and mass, or one sparse matrix of scipy.sparse.save_npz; optional nodes, equations
.h5    HDF5: datasets stiffness and mass, or groups of data, indices and indptr; optional nodes, equations
"""

from __future__ import annotations

import io
import logging
import re
import warnings
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.io
import scipy.sparse as sp

from fem.casing.imported.ansys import harwell_boeing, mapped_equations
from fem.casing.imported.imported_body import ImportedBody, MatrixError, imported_body
from fem.casing.imported.nastran import SUFFIXES as NASTRAN
from fem.casing.imported.nastran import grid_points, output4, punched, superelement_equations
from fem.processes.own_process import DAMAGED, READER, call_in_own_process
from fem.storage.hdf5_file import blocks_missing

if TYPE_CHECKING:
    import h5py

_log = logging.getLogger(__name__)
SUFFIXES = (".op4", ".pch", ".mtx", ".mmf", ".matrix", ".hb", ".rsa", ".sti", ".npz", ".h5", ".hdf5")
_COMPILED = (".h5", ".hdf5")  # read by the HDF5 library, which may crash
_STIFFNESS, _MASS = (
    ("stiffness", "k", "kaa", "kgg", "kxx", "kbb", "kaax"),
    ("mass", "m", "maa", "mgg", "mxx", "mbb", "maax"),
)

_UNUSED = {  # matrices that are not read, and the remedy
    **dict.fromkeys(("damping", "baa", "baax"), "Set casing.damping_ratio in the scene instead."),
    "rows": "It must hold three rows, x, y and z, for every node without equations. Export the casing again.",
}


@dataclass(frozen=True, eq=False)
class Found:
    """Matrices of a file by their names in lower case, and its nodes and equations if it has them."""

    matrices: Mapping[str, sp.spmatrix]
    equations: np.ndarray | None = None  # (n, 2)
    nodes: np.ndarray | None = None  # (k, 4) or (k, 3)


@dataclass(frozen=True, kw_only=True)
class MatrixFiles:
    """Files of an imported body: matrices in one file or two, and files of nodes and equations if these lack them."""

    stiffness: str
    mass: str | None = None
    nodes: str | None = None  # rows of number, x, y, z; GRID cards of Nastran; or *NODE of Abaqus
    equations: str | None = None  # rows of node, axis; or a Nastran file with EXTRN cards
    rows: str | None = None  # matrix of the motion of nodes without equations
    system: str = "kg-m-s"
    digests: tuple[str, ...] = field(default=())  # of the files, in this order


def read_body(files: MatrixFiles) -> ImportedBody:
    """The imported body in SI.

    Raises
    ------
    ForeignError : unreadable, of unknown kind, ambiguous matrices, or see `imported_body`
    """
    path = Path(files.stiffness)
    first = read_matrices(path)
    second = first if files.mass is None else read_matrices(Path(files.mass))
    given = files.nodes or (files.stiffness if _holds_grid(path) else None)
    nodes, frames = (first.nodes, None) if given is None else _nodes(Path(given))
    equations = first.equations if files.equations is None else _equations(Path(files.equations))
    rows = first.matrices.get("rows")
    if files.rows is not None:
        rows = _chosen(Path(files.rows), read_matrices(Path(files.rows)), ("rows",), "rows", alone=True)
    body = imported_body(
        path.name,
        _chosen(path, first, _STIFFNESS, "stiffness", alone=files.mass is not None),
        _chosen(Path(files.mass or path), second, _MASS, "mass", alone=files.mass is not None),
        equations=equations,
        nodes=nodes,
        frames=frames,
        rows=rows,
        system=files.system,
    )
    unused = _UNUSED.keys() & {*first.matrices, *second.matrices, *([] if rows is None else ["rows"])}
    if len(body.passive):
        unused -= {"rows"}
    notes = (f"{path.name}: the matrix {name} is not used. {_UNUSED[name]}" for name in sorted(unused))
    return replace(body, notes=tuple(notes))


def read_matrices(path: Path) -> Found:
    """All matrices of a file.

    Raises
    ------
    ForeignError : unreadable, of unknown kind, or a package is missing, which the message names
    """
    if path.suffix.lower() not in _READERS:
        raise MatrixError(f"{path.name}: matrices are read from {', '.join(SUFFIXES)}; convert it")
    if path.suffix.lower() in _COMPILED:
        return call_in_own_process(READER.format(path.name), MatrixError, DAMAGED, _read, path)
    return _read(path)


def _read(path: Path) -> Found:
    with _in_our_words(path):
        return _READERS[path.suffix.lower()](path)


@contextmanager
def _in_our_words(path: Path) -> Iterator[None]:
    """Replace any error of a reader by one sentence; the output of the reader goes to the log."""
    said = io.StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said):
            yield
    except MatrixError:
        raise
    except ImportError as error:
        raise MatrixError(f"{path.name} needs the package pyyeti: pip install 'gearcase[nastran]'") from error
    except FileNotFoundError as error:
        raise MatrixError(f"{error.filename}: no such file") from error
    except (Exception, SystemExit) as error:
        _log.info("%s: %s %s", path.name, error, said.getvalue())
        raise MatrixError(f"{path.name} cannot be read; {DAMAGED}") from error


def _chosen(path: Path, found: Found, names: tuple[str, ...], what: str, *, alone: bool) -> sp.spmatrix:
    """The matrix with one of the names; with `alone`, the only matrix of the file."""
    if alone and len(found.matrices) == 1:
        return next(iter(found.matrices.values()))
    if not (known := [name for name in names if name in found.matrices]):
        raise MatrixError(
            f"{path.name} has no {what} matrix under the names {', '.join(names)}; it holds "
            f"{', '.join(found.matrices) or 'nothing'}. Give it in a separate file"
        )
    return found.matrices[known[0]]


def _matrix_text(path: Path) -> Found:
    with path.open(encoding="latin-1") as file:
        head = file.readline()
    if head.startswith("%%MatrixMarket"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # the returned kind of matrix is converted
            return Found({"matrix": sp.coo_matrix(scipy.io.mmread(path))})
    text = path.read_text(encoding="latin-1").replace(",", " ")
    rows = np.loadtxt(io.StringIO(text), comments="*", ndmin=2)
    if rows.shape[1] == 3:
        one, two = rows[:, :2].astype(int).T - 1
        return Found({"matrix": sp.coo_matrix((rows[:, 2], (one, two)), shape=(1 + max(one.max(), two.max()),) * 2)})
    if rows.shape[1] != 5:
        raise MatrixError(
            f"{path.name}: its rows of {rows.shape[1]} numbers are in no known format. Export Matrix Market "
            "(first line %%MatrixMarket), or from Abaqus FORMAT=MATRIX INPUT (node, axis, node, axis, value) or "
            "COORDINATE (row, column, value)"
        )
    labels = rows[:, :4].astype(int)
    pairs, number = np.unique(np.vstack([labels[:, :2], labels[:, 2:]]), axis=0, return_inverse=True)
    one, two = number.ravel().reshape(2, -1)
    return Found({"matrix": sp.coo_matrix((rows[:, 4], (one, two)), shape=(len(pairs),) * 2)}, pairs)


def _calculix(path: Path) -> Found:
    labels = [line.split(".") for line in path.with_suffix(".dof").read_text(encoding="latin-1").split()]
    equations = np.array(labels, int)
    matrices = {}
    for name, file in (("stiffness", path), ("mass", path.with_suffix(".mas"))):
        rows = np.loadtxt(file, ndmin=2)
        one, two = rows[:, :2].astype(int).T - 1
        matrices[name] = sp.coo_matrix((rows[:, 2], (one, two)), shape=(len(equations),) * 2)
    return Found(matrices, equations)


def _npz(path: Path) -> Found:
    with zipfile.ZipFile(path) as archive:
        names = {name.removesuffix(".npy") for name in archive.namelist()}
    if {"data", "shape", "format"} <= names:
        return Found({"matrix": _sound(sp.load_npz(path))})
    with np.load(path, allow_pickle=False) as stored:
        arrays = {name.lower(): stored[name] for name in stored.files}
    return _of_arrays(arrays)


def _hdf5(path: Path) -> Found:
    import h5py

    arrays: dict[str, Any] = {}
    with h5py.File(path, "r") as file:
        for name, item in file.items():
            if isinstance(item, h5py.Group):
                if {"data", "indices", "indptr"} <= set(item):
                    packed = tuple(_complete(item[part], path) for part in ("data", "indices", "indptr"))
                    arrays[name.lower()] = _sound(sp.csr_matrix(packed))
            elif item.ndim == 2:
                square = item.shape[0] == item.shape[1]  # such a matrix may omit blocks of zeros
                arrays[name.lower()] = item[:] if square else _complete(item, path)
    if "ground_inertia" in arrays:
        raise MatrixError(
            f"{path.name} is a casing on its ground, which cannot be imported. Export the free body instead: gearcase "
            "casing SCENE --export casing.npz (or .mtx, .op4, .pch)"
        )
    return _of_arrays(arrays)


def _complete(dataset: h5py.Dataset, path: Path) -> np.ndarray:
    """The values of a dataset of HDF5. ForeignError if the file is incomplete."""
    if problem := blocks_missing(dataset):
        raise MatrixError(f"{path.name}: {str(dataset.name).strip('/')} {problem}; {DAMAGED}")
    return dataset[:]


def _sound(matrix: Any) -> Any:
    """A sparse matrix with valid indices. ValueError otherwise: SciPy would access memory out of bounds."""
    if hasattr(matrix, "check_format"):
        matrix.check_format(full_check=True)
    return matrix


def _of_arrays(arrays: Mapping[str, Any]) -> Found:
    lists = ("nodes", "equations")
    tables = {n: sp.csr_matrix(a) for n, a in arrays.items() if n not in lists and np.ndim(a) == 2 and a.shape[0]}
    return Found(tables, arrays.get("equations"), arrays.get("nodes"))


def _nodes(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """Numbers and positions of the nodes, with their frames if the file is one of Nastran."""
    if path.suffix.lower() not in (".inp", *NASTRAN):
        return _table(path, "nodes", (3, 4)), None
    with _in_our_words(path):
        return (_abaqus_nodes(path), None) if path.suffix.lower() == ".inp" else grid_points(path)


def _holds_grid(path: Path) -> bool:
    """Whether a punch file also holds nodes."""
    if path.suffix.lower() != ".pch":
        return False
    with path.open(encoding="latin-1") as lines:
        return any(line.startswith("GRID") for line in lines)


def _abaqus_nodes(path: Path) -> np.ndarray:
    """Number and position (k, 4) of the nodes of a flat input file (without parts and instances)."""
    rows, inside = [], False
    for line in path.read_text(encoding="latin-1").splitlines():
        if line.startswith("*"):
            inside = re.match(r"\*NODE\s*(,|$)", line, re.IGNORECASE) is not None or (inside and line.startswith("**"))
        elif inside and line.strip():
            rows.append([float(word) for word in line.split(",")[:4]])
    if not rows:
        raise MatrixError(f"{path.name} has no *NODE block")
    found = np.array(rows)
    if len(np.unique(found[:, 0])) < len(found):
        raise MatrixError(f"{path.name} numbers nodes twice, by parts; write it flat (a job without parts)")
    return found


def _equations(path: Path) -> np.ndarray:
    """Node and axis of every equation, from a file of Ansys or Nastran, or from rows of numbers."""
    if path.suffix.lower() not in (".mapping", *NASTRAN):
        return _table(path, "equations", (2,))
    with _in_our_words(path):
        return (mapped_equations if path.suffix.lower() == ".mapping" else superelement_equations)(path)


def _table(path: Path, what: str, columns: tuple[int, ...]) -> np.ndarray:
    """Rows of numbers of a text file."""
    with _in_our_words(path):
        text = path.read_text(encoding="latin-1").replace(",", " ").replace(";", " ")
        rows = [line.split() for line in text.splitlines() if line.strip() and line.strip()[0] in "-+.0123456789"]
        if len({len(row) for row in rows}) > 1:
            raise MatrixError(f"{path.name}: the rows of the {what} do not all have the same count of numbers")
        found = np.array(rows, float)
    if found.ndim != 2 or found.shape[1] not in columns:
        raise MatrixError(f"{path.name}: {what} are rows of {columns[-1]} numbers; these have the shape {found.shape}")
    return found


_READERS: dict[str, Callable[[Path], Found]] = {
    ".op4": lambda path: Found(output4(path)),
    ".pch": lambda path: Found(*punched(path)),
    **dict.fromkeys((".mtx", ".mmf"), _matrix_text),
    **dict.fromkeys((".matrix", ".hb", ".rsa"), lambda path: Found({"matrix": harwell_boeing(path)})),
    ".sti": _calculix,
    ".npz": _npz,
    ".h5": _hdf5,
    ".hdf5": _hdf5,
}
