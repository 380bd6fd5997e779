"""Static condensation of a prism by nested dissection: its interior is eliminated box by box in dense blocks.

The prism (section elements x axial elements) is divided in two recursively (`fem.elements.dissection`). A box is
assembled from its halves, and its inner unknowns are eliminated by a dense Cholesky factor,

    S = K_bb - K_bi K_ii^-1 K_ib.

Unknowns marked as kept remain at the root. The result is their Schur complement, from one factorisation without
right-hand sides, by the multifrontal method (Duff & Reid, 1983, ACM TOMS 9, 302-325). To order loaded nodes last is far
less expensive than one solution for every load. Unknowns of a box are in the order of their elimination, so that those
eliminated in it come first and blocks are added without permutation.

Nodes on a side may be tied to few shape functions, u = W q (`Ties`); the rows q are kept instead.

Parts of the prism may be empty (`Prism.filled`): they have no elements, and nodes without elements have no unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.elements.dissection import Box, Dissection
from fem.elements.twisted_hexahedra import axial_matrices, product_stiffness
from fem.numerics import blas
from fem.numerics.compiled import stored

INNER, KEPT, FIXED, TIED = range(4)

_Part = tuple[np.ndarray, np.ndarray]  # ascending positions in the elimination order; matrix (lower triangle)


class CondensationError(RuntimeError):
    """A box of the prism has no positive definite stiffness matrix."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Ties:
    """Displacement of tied nodes: u_c(node, z) = sum_ij across[node, i] along[z, j] q[side, c, ij], ij as used."""

    side: np.ndarray  # (section nodes,) 0 .. sides - 1, -1 if not tied
    across: np.ndarray  # (section nodes, functions), 0 if not tied
    along: np.ndarray  # (axial nodes, functions)
    used: np.ndarray  # bool (functions across, functions along), products used as functions q

    @property
    def count(self) -> int:
        """Number of unknowns q of one side."""
        return 3 * int(self.used.sum())

    def rows(self, node: np.ndarray, place: np.ndarray, component: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """W (unknowns, q) of tied unknowns at section nodes and axial nodes, and the numbers of its columns q."""
        sides = np.unique(self.side[node])
        out = np.zeros((len(node), len(sides), 3, self.count // 3))
        value = (self.across[node][:, :, None] * self.along[place][:, None, :])[:, self.used]
        out[np.arange(len(node)), np.searchsorted(sides, self.side[node]), component] = value
        return out.reshape(len(node), -1), (sides[:, None] * self.count + np.arange(self.count)).ravel()


# Elimination in one box, u_inner = -X u_rest with X = K_ii^-1 K_ib: numbers of the inner unknowns and the rest, and X
_Front = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(eq=False)
class Prism:
    """A prism to condense. roles (section nodes, 3) hold INNER, KEPT, FIXED or TIED for every component."""

    elements: np.ndarray  # (elements, 9) of the section
    grid: np.ndarray  # (elements, 2), row and column of the section
    blocks: np.ndarray  # (3, elements, 27, 27), of `fem.elements.twisted_hexahedra.section_blocks`
    ends: np.ndarray  # axial element ends, m
    roles: np.ndarray
    ties: Ties
    filled: np.ndarray  # bool (elements, axial elements), False where there is no material
    fronts: list[_Front] | None = None  # give a list to store the data for `recover`

    @property
    def size(self) -> int:
        """Number of unknowns of the mesh; the numbers of the tied functions q follow after them."""
        return self.roles.size * (2 * len(self.ends) - 1)

    def condense(self) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the remaining unknowns, ascending, and their stiffness matrix (N/m).

        Raises
        ------
        CondensationError : a part of the body is not held, or has a negative modulus
        """
        inner = self.roles == INNER
        dissection = Dissection(self.elements, self.grid, inner.sum(axis=1), self.filled)
        order, stops = self._eliminated(dissection, inner)
        turn = np.argsort(order)
        layers = [axial_matrices(ends) for ends in np.column_stack([self.ends[:-1], self.ends[1:]])]
        waiting: dict[int, _Part] = {}
        for number, box in enumerate(dissection.boxes):
            parts = [waiting.pop(half) for half in box.halves] or [self._leaf(box, layers[box.low], turn)]
            waiting[number] = self._eliminate(parts, order, stops[number])
        [(left, matrix)] = waiting.values()
        lower = np.tril(matrix)
        return order[left], lower + np.tril(matrix, -1).T

    def recover(self, numbers: np.ndarray, values: np.ndarray) -> np.ndarray:
        """All unknowns (size + tied, columns) from the remaining ones, for an unloaded interior."""
        out = np.zeros((self.size + 2 * self.ties.count, values.shape[1]))
        out[numbers] = values
        for inner, rest, solution in reversed(self.fronts or []):
            out[inner] = -solution @ out[rest]
        return out

    def _eliminated(self, dissection: Dissection, inner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Unknowns in the order of elimination, the remaining ones last, and the end of those of every box."""
        count = len(dissection.boxes)
        owner = np.where(inner, dissection.owners()[:, :, None], count).ravel()
        owner = np.append(owner, np.full(2 * self.ties.count, count))
        order = np.argsort(owner, kind="stable")
        return order, np.searchsorted(owner[order], np.arange(count), side="right")

    def _place(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Section node, axial node and component of unknowns of the mesh."""
        return numbers // 3 % len(self.roles), numbers // self.roles.size, numbers % 3

    def _eliminate(self, parts: list[_Part], order: np.ndarray, stop: int) -> _Part:
        """Add the parts of a box and eliminate the unknowns before `stop`."""
        turns = parts[0][0] if len(parts) == 1 else np.union1d(parts[0][0], parts[1][0])
        k = int(np.searchsorted(turns, stop))
        panel, C = np.zeros((len(turns), k), order="F"), np.zeros((len(turns) - k,) * 2, order="F")
        for own, matrix in parts:
            _add_lower(panel, C, matrix, np.searchsorted(turns, own))
        if not k:
            return turns, C
        L, B = panel[:k], panel[k:]
        if failed := blas.cholesky(L):
            node, layer, _ = self._place(order[turns[failed - 1 : failed]])
            raise CondensationError(
                f"solid mesh: the stiffness of a box of {k} unknowns near section node {node[0]}, layer {layer[0]} is "
                "not positive definite. Check bore radius, material and mesh refinement."
            )
        blas.solve_right(L, B, transposed=True)
        if self.fronts is not None:
            solution = B.copy(order="F")
            blas.solve_right(L, solution)
            self.fronts.append((order[turns[:k]], order[turns[k:]], solution.T))
        blas.add_square(B, C, -1.0)
        return turns[k:], C

    def _leaf(self, box: Box, axial: np.ndarray, turn: np.ndarray) -> _Part:
        """Stiffness of the elements of a box in one layer on its unknowns, in the order of elimination."""
        nodes, at = np.unique(self.elements[box.members], return_inverse=True)
        layer = 2 * box.low + np.arange(3)[:, None]
        numbers = ((layer * len(self.roles) + nodes)[:, :, None] * 3 + np.arange(3)).ravel()
        role = np.tile(self.roles[nodes].ravel(), 3)
        tied, free = np.flatnonzero(role == TIED), np.flatnonzero((role != TIED) & (role != FIXED))
        free = free[np.argsort(turn[numbers[free]])]
        count = len(free)
        place = np.full(len(numbers), -1)
        place[free], place[tied] = np.arange(count), count + np.arange(len(tied))
        dofs = (3 * at.reshape(-1, 1, 9, 1) + np.arange(3)).reshape(len(box.members), 1, 27)
        place = place[3 * len(nodes) * np.arange(3)[:, None] + dofs]
        section = np.take(self.blocks, box.members, axis=1)
        matrix: np.ndarray = product_stiffness(section, axial, place, count + len(tied))
        turns = turn[numbers[free]]
        if not len(tied):
            return turns, matrix.T
        rows, columns = self.ties.rows(*self._place(numbers[tied]))
        right = rows.T @ matrix[count:]  # of the functions q: they remain and come after all others
        square = right[:, count:] @ rows
        matrix = np.block([[matrix[:count, :count], right[:, :count].T], [right[:, :count], square]])
        return np.append(turns, turn[self.size + columns]), matrix.T


@stored(__file__)
def _add_lower(panel: np.ndarray, C: np.ndarray, matrix: np.ndarray, place: np.ndarray) -> None:
    """Add the lower triangle of `matrix` to that of a front, its first columns in `panel`, the others in `C`.

    Unknown i is at place[i] of the front, ascending; contiguous runs are added together.
    """
    k, count = panel.shape[1], len(place)
    ends = np.empty(count, np.int64)  # end of the contiguous run that contains i
    for i in range(count - 1, -1, -1):
        ends[i] = ends[i + 1] if i + 1 < count and place[i + 1] == place[i] + 1 else i + 1
    for j in range(count):
        column, i = place[j], j
        while i < count:
            end, row = ends[i], place[i]
            if column < k:
                for r in range(end - i):
                    panel[row + r, column] += matrix[i + r, j]
            else:
                for r in range(end - i):
                    C[row - k + r, column - k] += matrix[i + r, j]
            i = end
