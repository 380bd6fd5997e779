"""ForeignBody: imported stiffness and mass in SI, with the node and axis of every equation.

Matrices in a system of units with length L, mass m and time t (in m, kg, s) are converted by the unit of energy:

    A_SI = S A S m L^2 / t^2 (stiffness),  S A S m L^2 (mass),   S = diag(1 / L of translations, 1 of all others)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fem.casing.geometry.dimensions import HousingError

MODAL = -1  # axis of a coordinate that is not the motion of a node
POUND_FORCE_INCH = 175.12683524647636  # kg: 1 lbf s2/in, by 1 lbf = 4.4482216152605 N, 1 in = 0.0254 m
SYSTEMS = {  # length m, mass kg, time s
    "kg-m-s": (1.0, 1.0, 1.0),
    "t-mm-s": (1 / 1000, 1000.0, 1.0),
    "kg-mm-ms": (1 / 1000, 1.0, 1 / 1000),
    "kg-mm-s": (1 / 1000, 1.0, 1.0),
    "lbf-in-s": (127 / 5000, POUND_FORCE_INCH, 1.0),
}


class MatrixError(HousingError):
    """Imported matrices cannot be used because of a file, its equations, its units, or the body itself."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ImportedBody:
    """Imported K and M with the node and axis of each equation; SI."""

    name: str
    stiffness: sp.csr_matrix  # (n, n)
    mass: sp.csr_matrix
    node: np.ndarray  # int (n,), number of the node of every equation; of modal coordinates 0
    axis: np.ndarray  # int (n,), 0..5 for ux uy uz rx ry rz, MODAL
    numbers: np.ndarray  # int (k,), of the nodes
    places: np.ndarray  # (k, 3), m; nan where no file gives them
    passive: np.ndarray  # int (p,), indices in `numbers` of nodes without equations whose motion `rows` gives
    rows: sp.csr_matrix  # (3 p, n), their displacements along x, y, z
    dropped: int = 0  # equations without stiffness and mass that were left out
    notes: tuple[str, ...] = ()  # matrices of the file that are not used

    @property
    def located(self) -> bool:
        """Whether the positions of all nodes are known."""
        return bool(len(self.numbers) and np.isfinite(self.places).all())

    @property
    def displacements(self) -> tuple[np.ndarray, np.ndarray]:
        """Equations that are displacements, and the positions of their nodes in `numbers`."""
        order, moving = np.argsort(self.numbers), np.flatnonzero((self.axis >= 0) & (self.axis < 3))
        return moving, order[np.searchsorted(self.numbers, self.node[moving], sorter=order)]

    def place(self, number: int) -> np.ndarray:
        """Position (3,) of a node. ForeignError if there is no such node."""
        found = np.flatnonzero(self.numbers == number)
        if not len(found):
            known = f"it has {_some(self.numbers)}" if len(self.numbers) else "give its files of nodes and equations"
            raise MatrixError(f"{self.name} has no node {number}; {known}")
        return np.asarray(self.places[found[0]])


def imported_body(
    name: str,
    stiffness: sp.spmatrix,
    mass: sp.spmatrix,
    *,
    equations: np.ndarray | None = None,
    nodes: np.ndarray | None = None,
    frames: np.ndarray | None = None,
    rows: sp.spmatrix | None = None,
    system: str = "kg-m-s",
) -> ImportedBody:
    """An imported body from the data of its files.

    Parameters
    ----------
    name : of the file, in messages
    stiffness, mass : (n, n), symmetric or one triangle
    equations : int (n, 2), node and axis (1 to 6, 0 modal) of each; by default three or six per node, in node order
    nodes : (k, 4), number and position; or (k, 3), numbered from 1
    frames : (k, 3, 3), F with u = F u_node, of nodes whose equations are not written along x, y and z
    rows : (3 p or more, n), displacements of the p nodes without equations; not used if there are fewer
    system : one of `SYSTEMS`

    Raises
    ------
    ForeignError : shapes that do not match, entries that are not finite, equations of unknown nodes, nodes that lack an
        axis in their local frame
    """
    if system not in SYSTEMS:
        raise MatrixError(f"units {system!r} are not one of {', '.join(SYSTEMS)}")
    K, M = (_whole(name, what, matrix) for what, matrix in (("stiffness", stiffness), ("mass", mass)))
    if K.shape != M.shape:
        raise MatrixError(
            f"{name}: stiffness has {K.shape[0]} equations, mass {M.shape[0]}. Export both for the same set"
        )
    length, unit_mass, time = SYSTEMS[system]
    numbers, places = _nodes(name, nodes)
    node, axis = _equations(name, equations, K.shape[0], numbers)
    if not len(numbers):
        numbers = np.unique(node[axis != MODAL])
        places = np.full((len(numbers), 3), np.nan)
    if len(unknown := np.setdiff1d(node[axis != MODAL], numbers)):
        raise MatrixError(
            f"{name}: equations belong to nodes without coordinates: {_some(unknown)}. Give a file of all nodes"
        )
    passive = np.flatnonzero(~np.isin(numbers, node[axis != MODAL]))
    if rows is None or rows.shape[0] < 3 * len(passive) or rows.shape[1] != len(node):
        passive, rows = passive[:0], sp.csr_matrix((0, len(node)))
    rows = sp.csr_matrix(rows)[: 3 * len(passive)]
    if frames is not None:
        turn = _turned(name, node, axis, numbers, frames)
        K, M = (sp.csr_matrix(turn @ A @ turn.T) for A in (K, M))
        rows = rows @ turn.T
    scale = sp.diags_array(np.where((axis >= 0) & (axis < 3), 1.0 / length, 1.0))
    energy = unit_mass * length**2
    used = (abs(K).sum(axis=1) + abs(M).sum(axis=1) > 0.0).ravel()
    keep = np.flatnonzero(np.asarray(used).ravel())
    return ImportedBody(
        name=name,
        stiffness=sp.csr_matrix((scale @ K @ scale) * (energy / time**2))[keep][:, keep],
        mass=sp.csr_matrix((scale @ M @ scale) * energy)[keep][:, keep],
        node=node[keep],
        axis=axis[keep],
        numbers=numbers,
        places=length * places,
        passive=passive,
        rows=sp.csr_matrix(length * (rows @ scale))[:, keep],
        dropped=K.shape[0] - len(keep),
    )


def _whole(name: str, what: str, matrix: sp.spmatrix) -> sp.csr_matrix:
    """The matrix with both triangles."""
    found = sp.csr_matrix(matrix, dtype=float)
    if found.shape[0] != found.shape[1] or not found.shape[0]:
        raise MatrixError(f"{name}: the {what} matrix has the shape {found.shape}; it must be square and not empty")
    if not np.isfinite(found.data).all():
        raise MatrixError(f"{name}: the {what} matrix has entries that are not finite; export it again")
    upper, lower = sp.triu(found, 1), sp.tril(found, -1)
    if bool(upper.nnz) != bool(lower.nnz):
        found = sp.csr_matrix(found + upper.T + lower.T)
    found.sum_duplicates()
    return found


def _nodes(name: str, nodes: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    if nodes is None:
        return np.zeros(0, int), np.zeros((0, 3))
    nodes = np.atleast_2d(np.asarray(nodes, float))
    if nodes.shape[1] == 3:
        nodes = np.column_stack([np.arange(1, len(nodes) + 1), nodes])
    if nodes.shape[1] != 4 or not np.isfinite(nodes).all():
        raise MatrixError(f"{name}: nodes of shape {nodes.shape}. Give rows of number, x, y, z, or of x, y, z")
    return nodes[:, 0].astype(int), nodes[:, 1:]


def _equations(
    name: str, equations: np.ndarray | None, count: int, numbers: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    if equations is None:
        per_node = next((k for k in (3, 6) if len(numbers) * k == count), 0)
        if len(numbers) and not per_node:
            raise MatrixError(
                f"{name}: {count} equations of {len(numbers)} nodes are neither three nor six per node. Set "
                "equations_file (gearcase housing: --equations) to a file with a row of node and axis (1 to 6; 0 for a "
                "modal coordinate) for each equation"
            )
        if not per_node:  # no map of equations: coordinates without a position
            return np.zeros(count, int), np.full(count, MODAL)
        return np.repeat(numbers, per_node), np.tile(np.arange(per_node), len(numbers))
    rows = np.asarray(equations).astype(int)
    if rows.shape != (count, 2):
        raise MatrixError(
            f"{name}: the list of equations has the shape {rows.shape}. Give {count} rows of node and axis"
        )
    if ((rows[:, 1] < 0) | (rows[:, 1] > 6)).any():
        raise MatrixError(f"{name}: equations have axes outside 1 to 6 (0: modal). Correct them")
    return np.where(rows[:, 1] > 0, rows[:, 0], 0), rows[:, 1] - 1


def _turned(name: str, node: np.ndarray, axis: np.ndarray, numbers: np.ndarray, frames: np.ndarray) -> sp.csr_matrix:
    """T (n, n) with A = T A_nodes T^T: transforms the equations of every node from its frame to x, y and z."""
    turn = sp.lil_matrix(sp.eye_array(len(node)))
    for number, frame in zip(numbers, frames, strict=True):
        if np.allclose(frame, np.eye(3), rtol=0.0, atol=1e-12):
            continue
        for first in (0, 3):
            own = [np.flatnonzero((node == number) & (axis == first + k)) for k in range(3)]
            found = [len(one) for one in own]
            if found == [0, 0, 0]:
                continue
            if found != [1, 1, 1]:
                raise MatrixError(
                    f"{name}: node {number} moves in a local coordinate system and lacks an axis; export all "
                    "three, or the node in the basic system"
                )
            at = np.concatenate(own)
            turn[np.ix_(at, at)] = frame
    return sp.csr_matrix(turn)


def _some(numbers: np.ndarray) -> str:
    return ", ".join(map(str, numbers[:6].tolist())) + (f", ... ({len(numbers)} in all)" if len(numbers) > 6 else "")
