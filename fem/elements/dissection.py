"""Nested dissection of a prism: the boxes in which its unknowns are eliminated, in order.

A prism (section elements x axial elements) is divided in two recursively. The section elements are on a grid of rows
and columns, so a cut is a row line, a column line or a plane across the axis. The cut with the least ratio of size to
balance is used,

    unknowns on the cut / (elements on one side * elements on the other),

since the unknowns on a cut remain in dense blocks. Sizes in metres are ignored: deep in a body elements are large and
few. An unknown is eliminated in the smallest box that contains all elements touching it.

References: George (1973), SIAM J. Numer. Anal. 10, 345-363; Hagen & Kahng (1992), IEEE Trans. CAD 11, 1074-1085 (cuts
by their size over the product of the sides).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_LEAF = 6  # section elements, in one layer, that are assembled together: smaller leaves only add calls


@dataclass(frozen=True, eq=False)
class Box:
    """Section elements in the layers low .. high; halves are numbers of boxes before this one.

    A box without halves is a leaf: few elements in one layer.
    """

    members: np.ndarray
    low: int
    high: int
    halves: tuple[int, ...]


# The best cut of a set of section elements: both sides (None for a single element), its unknowns in every layer, and
# those of a plane across the axis
_Cut = tuple[tuple[np.ndarray, np.ndarray] | None, int, int]


class Dissection:
    """Boxes of a prism, halves before the whole.

    Parameters
    ----------
    elements : int (elements, 9), nodes of the section elements
    grid : int (elements, 2), row and column
    weight : int (section nodes,), unknowns of a node that can be eliminated
    filled : bool (elements, layers), False where there is no material
    """

    def __init__(self, elements: np.ndarray, grid: np.ndarray, weight: np.ndarray, filled: np.ndarray) -> None:
        self._elements, self._grid, self._weight, self._filled = elements, grid, weight, filled
        self._known: dict[bytes, _Cut] = {}
        self.boxes: list[Box] = []
        self._divide(np.arange(len(elements)), 0, filled.shape[1])

    def owners(self) -> np.ndarray:
        """Number of the box (axial nodes, section nodes) in which a node is eliminated; -1 without elements."""
        nodes, layers = len(self._weight), self._filled.shape[1]
        first, last = (np.full((2 * layers + 1, nodes), -1) for _ in range(2))
        leaves = [(number, box) for number, box in enumerate(self.boxes) if not box.halves]
        for found, order in ((last, leaves), (first, leaves[::-1])):
            for number, box in order:
                found[2 * box.low : 2 * box.high + 1, self._elements[box.members]] = number
        out = np.full_like(first, -1)
        begins: list[int] = []  # first box within every box
        for number, box in enumerate(self.boxes):
            begins.append(begins[box.halves[0]] if box.halves else number)
            at = np.ix_(np.arange(2 * box.low, 2 * box.high + 1), np.unique(self._elements[box.members]))
            done = (out[at] < 0) & (first[at] >= begins[-1]) & (last[at] <= number)
            out[at] = np.where(done, number, out[at])
        return out

    def _divide(self, members: np.ndarray, low: int, high: int) -> tuple[int, ...]:
        """The number of a new box, or nothing if it is empty."""
        members = members[self._filled[members, low:high].any(axis=1)]
        if not len(members):
            return ()
        layers = high - low
        halves: tuple[int, ...] = ()
        if len(members) > _LEAF or layers > 1:
            sides, along, across = self._cut(members)
            share = np.inf
            if sides is not None:
                share = along * (2 * layers + 1) / (len(sides[0]) * len(sides[1]) * layers**2)
            middle = (low + high) // 2
            if layers > 1 and across / ((middle - low) * (high - middle) * len(members) ** 2) <= share:
                halves = self._divide(members, low, middle) + self._divide(members, middle, high)
            else:
                assert sides is not None
                halves = self._divide(sides[0], low, high) + self._divide(sides[1], low, high)
        self.boxes.append(Box(members, low, high, halves))
        return (len(self.boxes) - 1,)

    def _cut(self, members: np.ndarray) -> _Cut:
        key = members.tobytes()
        if key not in self._known:
            self._known[key] = self._best(members)
        return self._known[key]

    def _best(self, members: np.ndarray) -> _Cut:
        nodes, at = np.unique(self._elements[members], return_inverse=True)
        at, weight = at.reshape(-1, 9), self._weight[nodes]
        best, sides, along = np.inf, None, 0
        for line in self._grid[members].T:
            for start in np.unique(line)[1:]:
                low = line < start
                touched = np.zeros((2, len(nodes)), dtype=bool)
                touched[0, at[low]] = touched[1, at[~low]] = True
                unknowns = int(weight[touched.all(axis=0)].sum())
                share = unknowns / (low.sum() * (~low).sum())
                if share < best:
                    best, sides, along = share, (members[low], members[~low]), unknowns
        return sides, along, int(weight.sum())
