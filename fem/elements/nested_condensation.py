"""Static condensation of a prism by nested bisection: its interior is eliminated in dense blocks, box by box.

The prism (section elements x axial elements) is cut in two again and again, across its longest side. A box is assembled
from its halves and whatever lies inside it for good is eliminated by a dense Cholesky factor,

    S = K_bb - K_bi K_ii^-1 K_ib.

Unknowns marked as kept survive to the root: the result is the Schur complement on them, at the price of one
factorisation and with no right sides at all. This is nested dissection (George, 1973, SIAM J. Numer. Anal. 10, 345-363)
by the multifrontal method (Duff & Reid, 1983, ACM TOMS 9, 302-325). Loaded nodes "ordered last" are far cheaper than
one solution for every load.

Nodes on a side may be tied to few shape functions, u = W q (`Ties`): the rows q are kept in their place.

Parts of the prism may be empty (`Prism.filled`): there are no elements, and what no element touches is no unknown.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fem.elements.prisms import SectionBlocks, axial_matrices, product_stiffness
from fem.numerics import blas
from fem.numerics.compiled import stored

INNER, KEPT, FIXED, TIED = range(4)
_LEAF_SECTION, _LEAF_AXIAL = 6, 2  # largest box that is assembled at once

_Part = tuple[np.ndarray, np.ndarray]  # numbers of unknowns, rising, and a matrix on them whose lower triangle counts


class CondensationError(RuntimeError):
    """A box of the prism has no positive definite stiffness matrix."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Ties:
    """Displacement of tied nodes: u_c(node, z) = sum_ij across[node, i] along[z, j] q[side, c, ij], ij as used."""

    side: np.ndarray  # (section nodes,) 0 .. sides - 1, -1 where not tied
    across: np.ndarray  # (section nodes, functions), 0 where not tied
    along: np.ndarray  # (axial nodes, functions)
    used: np.ndarray  # bool (functions across, functions along), products that are functions q

    @property
    def count(self) -> int:
        """Unknowns q of one side."""
        return 3 * int(self.used.sum())

    def rows(self, node: np.ndarray, place: np.ndarray, component: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """W (unknowns, q) of tied unknowns at section nodes and axial nodes, and the numbers of its columns q."""
        sides = np.unique(self.side[node])
        out = np.zeros((len(node), len(sides), 3, self.count // 3))
        value = (self.across[node][:, :, None] * self.along[place][:, None, :])[:, self.used]
        out[np.arange(len(node)), np.searchsorted(sides, self.side[node]), component] = value
        return out.reshape(len(node), -1), (sides[:, None] * self.count + np.arange(self.count)).ravel()


@dataclass(frozen=True, eq=False)
class Front:
    """What was eliminated in one box: u_inner = -X u_rest with X = K_ii^-1 K_ib, by unknown numbers."""

    inner: np.ndarray
    rest: np.ndarray
    solution: np.ndarray


@dataclass(eq=False)
class Prism:
    """A prism to condense. roles (section nodes, 3) hold INNER, KEPT, FIXED or TIED for every component."""

    elements: np.ndarray  # (elements, 9) of the section
    centres: np.ndarray  # (elements, 2), m
    blocks: SectionBlocks
    ends: np.ndarray  # axial element ends, m
    roles: np.ndarray
    ties: Ties
    filled: np.ndarray  # bool (elements, axial elements), False where there is no material
    fronts: list[Front] | None = None  # give a list to keep what recovery needs
    _touched: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self._touched = self._touching(np.arange(len(self.elements)), 0, len(self.ends) - 1)

    @property
    def size(self) -> int:
        """Unknowns of the mesh; the numbers of the tied functions q follow after them."""
        return self.roles.size * (2 * len(self.ends) - 1)

    def condense(self) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the surviving unknowns, rising, and their stiffness matrix (N/m).

        Raises
        ------
        CondensationError : a part of the body is not held, or has a negative modulus
        """
        numbers, matrix = self._box(np.arange(len(self.elements)), 0, len(self.ends) - 1)
        lower = np.tril(matrix)
        return numbers, lower + np.tril(matrix, -1).T

    def recover(self, numbers: np.ndarray, values: np.ndarray) -> np.ndarray:
        """All unknowns (size + tied, columns) from the surviving ones, when nothing loads the interior."""
        out = np.zeros((self.size + 2 * self.ties.count, values.shape[1]))
        out[numbers] = values
        for front in reversed(self.fronts or []):
            out[front.inner] = -front.solution @ out[front.rest]
        return out

    def _box(self, members: np.ndarray, low: int, high: int) -> _Part:
        layers = high - low
        members = members[self.filled[members, low:high].any(axis=1)]
        if not len(members):
            return np.zeros(0, dtype=int), np.zeros((0, 0))
        if len(members) <= _LEAF_SECTION and layers <= _LEAF_AXIAL and self.filled[members, low:high].all():
            halves = [self._leaf(members, low, high)]
        else:
            spread = self.centres[members] - self.centres[members].mean(axis=0)
            longer = self.ends[high] - self.ends[low] > 1.2 * np.ptp(spread, axis=0).max()
            if layers > 1 and (longer or len(members) <= _LEAF_SECTION):
                middle = (low + high) // 2
                halves = [self._box(members, low, middle), self._box(members, middle, high)]
            else:
                axis = np.linalg.eigh(spread.T @ spread)[1][:, 1]
                order = members[np.argsort(spread @ axis, kind="stable")]
                cut = len(members) // 2
                halves = [self._box(np.sort(part), low, high) for part in (order[:cut], order[cut:])]
        return self._eliminate(halves, members, low, high)

    def _place(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Section node, axial node and component of unknowns of the mesh."""
        return numbers // 3 % len(self.roles), numbers // self.roles.size, numbers % 3

    def _touching(self, members: np.ndarray, low: int, high: int) -> np.ndarray:
        """Number of elements of a box at its nodes, (axial nodes of the box, section nodes)."""
        out = np.zeros((2 * (high - low) + 1, len(self.roles)), dtype=int)
        for layer in range(low, high):
            here = members[self.filled[members, layer]]
            at = 2 * (layer - low)
            out[at : at + 3] += np.bincount(self.elements[here].ravel(), minlength=len(self.roles))
        return out

    def _inside(self, numbers: np.ndarray, members: np.ndarray, low: int, high: int) -> np.ndarray:
        """Which of the unknowns no element outside the box touches, and are not kept."""
        full = self._touching(members, low, high) == self._touched[2 * low : 2 * high + 1]
        mesh = numbers < self.size
        node, place, component = self._place(np.where(mesh, numbers, self.roles.size * 2 * low))
        return mesh & full[place - 2 * low, node] & (self.roles[node, component] == INNER)

    def _eliminate(self, parts: list[_Part], members: np.ndarray, low: int, high: int) -> _Part:
        """Add the parts of a box and eliminate what lies inside it for good: those unknowns come first in the front."""
        numbers = parts[0][0] if len(parts) == 1 else np.union1d(parts[0][0], parts[1][0])
        inside = self._inside(numbers, members, low, high)
        inner, rest = numbers[inside], numbers[~inside]
        place = np.where(inside, np.cumsum(inside) - 1, len(inner) + np.cumsum(~inside) - 1)
        front = np.zeros((len(numbers), len(numbers)), order="F")
        for own, matrix in parts:
            _add_lower(front, matrix, place[np.searchsorted(numbers, own)])
        k = len(inner)
        if not k:
            return rest, front
        L, B, C = front[:k, :k], front[k:, :k], front[k:, k:]
        if failed := blas.cholesky(L):
            node, layer, _ = self._place(inner[failed - 1 : failed])
            raise CondensationError(
                f"solid mesh: the stiffness of a box of {k} unknowns near section node {node[0]}, layer {layer[0]} is "
                "not positive definite. Check bore radius, material and mesh refinement."
            )
        blas.solve_right(L, B, transposed=True)
        if self.fronts is not None:
            solution = B.copy(order="F")
            blas.solve_right(L, solution)
            self.fronts.append(Front(inner, rest, solution.T))
        blas.add_square(B, C, -1.0)
        return rest, C.copy(order="F")

    def _leaf(self, members: np.ndarray, low: int, high: int) -> _Part:
        nodes = np.unique(self.elements[members])
        at = np.searchsorted(nodes, self.elements[members])
        dofs = (3 * at[:, :, None] + np.arange(3)).reshape(len(members), 27)
        chosen = SectionBlocks(self.blocks.plane[members], self.blocks.mixed[members], self.blocks.axial[members])
        matrix = product_stiffness(chosen, dofs, 3 * len(nodes), axial_matrices(self.ends[low : high + 1]))
        layer = np.arange(2 * low, 2 * high + 1)
        numbers = ((layer[:, None] * len(self.roles) + nodes)[:, :, None] * 3 + np.arange(3)).ravel()
        node, place, component = self._place(numbers)
        role = self.roles[node, component]
        tied, free = np.flatnonzero(role == TIED), np.flatnonzero((role != TIED) & (role != FIXED))
        if not len(tied):
            return numbers[free], matrix[np.ix_(free, free)]
        rows, columns = self.ties.rows(node[tied], place[tied], component[tied])
        right = matrix[:, tied] @ rows
        joined = np.block([[matrix[np.ix_(free, free)], right[free]], [right[free].T, rows.T @ right[tied]]])
        return np.concatenate([numbers[free], self.size + columns]), joined


@stored(__file__)
def _add_lower(front: np.ndarray, matrix: np.ndarray, place: np.ndarray) -> None:
    """Add the lower triangle of `matrix` to that of `front`; unknown i of it stands at place[i] there."""
    for j in range(len(place)):
        for i in range(j, len(place)):
            row, column = place[i], place[j]
            if row < column:
                row, column = column, row
            front[row, column] += matrix[i, j]
