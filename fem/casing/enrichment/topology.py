"""Numbered faces and sides (element edges) of a mesh of hexahedra, and local coordinates at a side."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import product

import numpy as np

from fem.elements.solid_elements import SOLIDS, shapes, solid_element


@dataclass(frozen=True, eq=False)
class Sector:
    """An element at a side: its reference coordinates are origin + axes @ (xi, eta, s), the side at xi = eta = 0."""

    element: int
    origin: np.ndarray  # (3,), 0 or 1
    axes: np.ndarray  # (3, 3), columns of one 1 or -1 each

    def places(self, local: np.ndarray) -> np.ndarray:
        """Reference coordinates (3, q) of points (3, q) at xi, eta, s."""
        return self.origin[:, None] + self.axes @ local

    def axis(self, direction: int, end: int) -> tuple[int, int]:
        """Reference axis along xi, eta or s (direction 0, 1, 2), and the side (0 or 1) where that is `end`."""
        axis = int(abs(self.axes[:, direction]).argmax())
        return axis, round(float(self.origin[axis] + end * self.axes[axis, direction]))

    def turned(self) -> Sector:
        """The sector with xi and eta exchanged."""
        return replace(self, axes=self.axes[:, [1, 0, 2]])

    def backwards(self) -> Sector:
        """The sector with s reversed."""
        axes = np.column_stack([self.axes[:, :2], -self.axes[:, 2]])
        return replace(self, origin=self.origin + self.axes[:, 2], axes=axes)


class Topology:
    """Adjacency of the faces and sides of the elements in a mesh of hexahedra.

    Parameters
    ----------
    nodes, elements : (n, 3) m and (e, 20 or 27)
    facets, patch : surface (f, k) and the patch (f,) of each facet, -1 for none

    Attributes
    ----------
    face : int (e, 3, 2), numbers of the faces by reference axis and side
    outer, patch : bool and int (face,), whether a face is one of the body, and its patch
    side : int (e, 3, 2, 2), numbers of the sides by the axis along them and the ends of the two other axes
    ends : int (side, 2), corner nodes
    """

    def __init__(self, nodes: np.ndarray, elements: np.ndarray, facets: np.ndarray, patch: np.ndarray) -> None:
        self.nodes, self.elements, self.kind = nodes, elements, solid_element(elements)
        corners = elements[:, _corner_at()].astype(np.int64)  # (e, 2, 2, 2)
        around = np.stack([np.moveaxis(corners, 1 + axis, 1).reshape(-1, 2, 4) for axis in range(3)], axis=1)
        keys, number = np.unique(np.sort(around, axis=3).reshape(-1, 4), axis=0, return_inverse=True)
        self.face = number.reshape(-1, 3, 2)
        self.outer = np.bincount(number.ravel(), minlength=len(keys)) == 1
        self._face_users = _grouped(number.ravel(), len(keys))
        self.patch = np.full(len(keys), -1)
        outer = np.flatnonzero(self.outer).tolist()
        self._outer_at = {tuple(key): at for key, at in zip(keys[self.outer].tolist(), outer, strict=True)}
        self.mark(facets, patch)
        along = np.stack([np.moveaxis(corners, 1 + axis, 3).reshape(-1, 4, 2) for axis in range(3)], axis=1)
        self.ends, number = np.unique(np.sort(along, axis=3).reshape(-1, 2), axis=0, return_inverse=True)
        self.side = number.reshape(-1, 3, 2, 2)
        self._side_users = _grouped(number.ravel(), len(self.ends))

    def mark(self, facets: np.ndarray, patch: np.ndarray | int) -> None:
        """Assign facets (f, k) of the surface to a patch, or each to its own (f,)."""
        at = [self._outer_at[tuple(corners)] for corners in np.sort(facets[:, :4], axis=1).tolist()]
        self.patch[at] = patch

    def users(self, side: int) -> list[tuple[int, int, tuple[int, int]]]:
        """Element, axis and ends of the other axes of every element at a side."""
        found = np.array(np.unravel_index(_of_group(self._side_users, side), self.side.shape)).T
        return [(int(e), int(axis), (int(b), int(c))) for e, axis, b, c in found]

    def sector(self, element: int, axis: int, across: tuple[int, int]) -> Sector:
        """Sector of an element at a side; s runs from the end with the lower node number to the other."""
        first, second = (one for one in range(3) if one != axis)
        origin, axes = np.zeros(3), np.zeros((3, 3))
        origin[[first, second]] = across
        axes[first, 0], axes[second, 1] = (1.0 - 2.0 * end for end in across)
        axes[axis, 2] = 1.0
        found = Sector(element, origin, axes)
        low, high = (self.node(found, (0.0, 0.0, s)) for s in (0.0, 1.0))
        return found if low < high else found.backwards()

    def beyond(self, sector: Sector, end: int) -> Sector | None:
        """The element across the face s = `end` (0 or 1): same xi and eta, s increases from there; or None."""
        face = self.face_at(sector, 2, end)
        if self.outer[face]:
            return None
        users = _of_group(self._face_users, face) // 6
        element = int(users[users != sector.element][0])
        at = dict(zip(self.elements[element, :8].tolist(), _corner_places(), strict=True))
        zero, one, other = (at[self.node(sector, (x, y, float(end)))] for x, y in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)))
        axes = np.column_stack([one - zero, other - zero, np.zeros(3)])
        along = int(abs(axes).sum(axis=1).argmin())
        axes[along, 2] = 1.0 - 2.0 * zero[along]
        return Sector(element, zero, axes)

    def node(self, sector: Sector, local: tuple[float, float, float]) -> int:
        """The node of an element at xi, eta, s (0, 1/2 or 1)."""
        place = np.round(2.0 * (sector.origin + sector.axes @ local)).astype(int)
        return int(self.elements[sector.element, _number_at(self.kind.name)[tuple(place.tolist())]])

    def face_at(self, sector: Sector, direction: int, end: int) -> int:
        """Number of the face where xi, eta or s (0, 1, 2) is 0 or 1."""
        return int(self.face[(sector.element, *sector.axis(direction, end))])

    def side_along(self, sector: Sector, xi: int, eta: int) -> int:
        """Number of the side of an element along s at xi, eta."""
        axis, _ = sector.axis(2, 0)
        place = sector.origin + sector.axes[:, 0] * xi + sector.axes[:, 1] * eta
        across = [round(float(place[one])) for one in range(3) if one != axis]
        return int(self.side[sector.element, axis, across[0], across[1]])

    def points(self, sector: Sector, local: np.ndarray) -> np.ndarray:
        """Points in space (q, 3) at xi, eta, s (3, q)."""
        values, _ = _shapes(self.kind.name, sector.places(local).tobytes())
        return np.asarray(values @ self.nodes[self.elements[sector.element]])

    def frame(self, sector: Sector, s: float) -> np.ndarray:
        """Columns (3, 3) in space: along the face eta = 0, across it, along the edge, at s on the side of a sector."""
        _, slopes = _shapes(self.kind.name, sector.places(np.array([[0.0], [0.0], [s]])).tobytes())
        J = self.nodes[self.elements[sector.element]].T @ slopes[0] @ sector.axes
        t = J[:, 2] / np.linalg.norm(J[:, 2])
        n = J[:, 0] - (J[:, 0] @ t) * t
        n /= np.linalg.norm(n)
        return np.column_stack([n, np.cross(t, n), t])

    def angles(self) -> np.ndarray:
        """Angle (e, 3, 2, 2) between the two faces of every element half-way along its sides."""
        out = np.empty(self.side.shape)
        places = self.nodes[self.elements]
        for axis, b, c in np.ndindex(3, 2, 2):
            first, second = (one for one in range(3) if one != axis)
            at = np.full((3, 1), 0.5)
            at[first], at[second] = b, c
            _, slopes = shapes(self.kind.library, at)
            J = np.einsum("ar,ead->erd", slopes[0], places)
            t = J[:, axis] / np.linalg.norm(J[:, axis], axis=1, keepdims=True)
            u, v = (1 - 2 * b) * J[:, first], (1 - 2 * c) * J[:, second]
            u, v = (d - (d * t).sum(axis=1, keepdims=True) * t for d in (u, v))
            out[:, axis, b, c] = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1))
        return out


def _grouped(number: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Indices at which each number occurs, sorted by number, and the start of each number in them."""
    order = np.argsort(number, kind="stable")
    return order, np.searchsorted(number[order], np.arange(count + 1))


def _of_group(groups: tuple[np.ndarray, np.ndarray], number: int) -> np.ndarray:
    order, start = groups
    return order[start[number] : start[number + 1]]


@cache
def _shapes(kind: str, places: bytes) -> tuple[np.ndarray, np.ndarray]:
    return shapes(SOLIDS[kind].library, np.frombuffer(places).reshape(3, -1))


@cache
def _corner_places() -> np.ndarray:
    return np.asarray(SOLIDS["hexahedron-8"].library.doflocs)


@cache
def _corner_at() -> np.ndarray:
    """Local numbers (2, 2, 2) of the corners by their reference coordinates."""
    number = _number_at("hexahedron-8")
    return np.array([number[place] for place in product((0, 2), repeat=3)]).reshape(2, 2, 2)


@cache
def _number_at(kind: str) -> dict[tuple[int, ...], int]:
    """Local numbers of nodes by twice their reference coordinates."""
    places = np.round(2 * SOLIDS[kind].library.doflocs).astype(int)
    return {tuple(place): number for number, place in enumerate(places.tolist())}
