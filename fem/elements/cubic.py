"""Cubic displacements in ten-node tetrahedra and 20-node hexahedra: functions added to the quadratic ones.

Every side (element edge) and every face with a function (`fem.elements.cubic_shapes`) has three unknowns, along x, y
and z. On a side the function is oriented from the node with the lower number, so that neighbours share it. One element
through a wall then represents the bending and shear of a plate, whose displacements are cubic across the wall. The
geometry remains that of the nodes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fem.elements.cubic_shapes import CUBIC, cubic_shapes, faces_of, sides_of
from fem.elements.solid_elements import AXES, CURVED_RULE, SolidElement, rule, shapes

_RULES = {4: (CURVED_RULE - 2, CURVED_RULE), 8: (7, 7)}  # by corners: of affine elements (degree 6, exact), of others
_AFFINE = 1e-9  # of the size of an element: tolerance of an affine map of the reference element
_CHUNK = 50000  # quadrature points evaluated together


@dataclass(frozen=True, eq=False)
class CubicFunctions:
    """The functions of all sides and faces that are not held, three unknowns each."""

    numbers: np.ndarray  # (m,), of each unknown among those at the same position
    places: np.ndarray  # (m, 3), m, positions of their functions
    points: np.ndarray  # (n, 3), m
    elements: np.ndarray  # (e, k)
    functions: np.ndarray  # (e, f), numbers of those of its sides and faces, including held ones
    moving: np.ndarray  # (function,), bool

    @property
    def kind(self) -> SolidElement:
        """The resulting cubic element."""
        return CUBIC[self.elements.shape[1]]

    def __len__(self) -> int:
        """Number of added unknowns."""
        return len(self.numbers)

    def moving_numbers(self, elements: np.ndarray) -> np.ndarray:
        """Numbers (e, f) of the functions of some elements among those not held, -1 for held ones."""
        number = np.where(self.moving, np.cumsum(self.moving) - 1, -1)
        return np.asarray(number[self.functions[elements]])

    def unknowns(self, elements: np.ndarray) -> np.ndarray:
        """Numbers (e, 3, f) of the unknowns of some elements along x, y, z; -1 of functions that are held."""
        number = self.moving_numbers(elements)[:, None]
        first = 3 * len(self.points)
        return np.asarray(np.where(number < 0, -1, first + 3 * number + np.arange(3)[:, None]))

    def signs(self, elements: np.ndarray) -> np.ndarray:
        """Signs (e, f) of the functions of some elements: -1 on a side that starts at its higher node number."""
        ends = self.elements[elements][:, sides_of(self.kind)]
        out = np.ones((len(elements), self.functions.shape[1]))
        out[:, : ends.shape[1]] = np.where(ends[:, :, 0] < ends[:, :, 1], 1.0, -1.0)
        return out

    def products(self, elements: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Products as in `fem.elements.solids`, for all functions of some elements; 0 for pairs of nodes."""
        k = self.elements.shape[1]
        for part, products, mass in _products(self.kind, self.points, self.elements[elements]):
            sign = np.column_stack([np.ones((len(part), k)), self.signs(elements[part])])
            turn = sign[:, :, None] * sign[:, None, k:]
            size = sign.shape[1]
            out, masses = np.zeros((len(AXES), len(part), size, size)), np.zeros((len(part), size, size))
            for whole, right, left in (
                (masses, mass, mass),
                *((one, products[i, j], products[j, i]) for one, (i, j) in zip(out, AXES, strict=True)),
            ):
                whole[:, :, k:] = right * turn
                whole[:, k:, :k] = (left * turn)[:, :k].transpose(0, 2, 1)
            yield part, out, masses


def cubic_functions(points: np.ndarray, elements: np.ndarray, held: np.ndarray) -> CubicFunctions:
    """The functions of all sides and faces of a mesh.

    Parameters
    ----------
    points, elements : (n, 3) m and (e, k), ten-node tetrahedra or 20-node hexahedra
    held : (f, 3 or more), corners first, of facets on which the displacements are those of the nodes: clamped or rigid
    """
    kind = CUBIC[elements.shape[1]]
    around = 3 if kind.corners == 4 else 4
    held = held[:, :around]
    rims = np.stack([held, np.roll(held, -1, axis=1)], axis=2).reshape(-1, 2)
    sides, of_sides = _numbered(elements, sides_of(kind))
    faces, of_faces = _numbered(elements, faces_of(kind))
    moving = np.concatenate([~_among(sides, np.sort(rims, axis=1)), ~_among(faces, np.sort(held[:, :3], axis=1))])
    places = np.concatenate([points[sides].mean(axis=1), points[faces].mean(axis=1)])[moving]
    return CubicFunctions(
        numbers=np.tile(np.arange(3), len(places)),
        places=np.repeat(places, 3, axis=0),
        points=points,
        elements=elements,
        functions=np.column_stack([of_sides, len(sides) + of_faces]),
        moving=moving,
    )


def _numbered(elements: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ascending corners (m, 2 or 3) of all sides or faces of a mesh, and their numbers (e, local)."""
    own = np.sort(elements[:, corners].reshape(-1, corners.shape[1]), axis=1)
    found, number = np.unique(own, axis=0, return_inverse=True)
    return found, number.reshape(len(elements), len(corners))


def _products(
    kind: SolidElement, points: np.ndarray, elements: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Numbers (p,), int d_i phi_a d_j phi_b dV (3, 3, p, a, f) and int phi_a phi_b dV (p, a, f), in parts."""
    straight, k = _affine(kind, points, elements), kind.nodes
    for affine, degree in zip((True, False), _RULES[kind.corners], strict=True):
        members = np.flatnonzero(straight == affine)
        at, weights = rule(kind.library, degree)
        (values, slopes), (_, of_map) = cubic_shapes(kind, at), shapes(kind.library, at)
        functions, added = values.shape[1], values.shape[1] - k
        masses = np.einsum("q,qa,qb->ab", weights, values, values[:, k:])
        tensor = np.einsum("q,qar,qbs->rsab", weights, slopes, slopes[:, k:], optimize=True).reshape(9, -1)
        for part in np.array_split(members, -(-len(members) * len(weights) // _CHUNK)) if len(members) else ():
            places = points[elements[part]]
            if affine:
                jacobian = np.einsum("ar,ead->edr", of_map[0], places)
                volume, inverse = np.linalg.det(jacobian), np.linalg.inv(jacobian)
                pairs = np.einsum("e,eri,esj->ijers", volume, inverse, inverse, optimize=True)
                products = (pairs.reshape(-1, 9) @ tensor).reshape(3, 3, len(part), functions, added)
                yield part, products, volume[:, None, None] * masses
                continue
            jacobian = np.einsum("qar,ead->eqdr", of_map, places, optimize=True)
            volume = weights * np.linalg.det(jacobian)
            gradient = np.einsum("qar,eqri->ieqa", slopes, np.linalg.inv(jacobian), optimize=True)
            weighted = (gradient * volume[:, :, None]).transpose(0, 1, 3, 2)
            products = weighted[:, None] @ gradient[None, :, :, :, k:]
            yield part, products, (volume[:, None, :] * values.T) @ values[:, k:]


def _affine(kind: SolidElement, points: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Bool (e,): whether all nodes follow from an affine map of the reference element."""
    reference = kind.library.doflocs
    origin, *ends = (int(abs(reference - corner).sum(axis=1).argmin()) for corner in (np.zeros(3), *np.eye(3)))
    places = points[elements] - points[elements[:, [origin]]]
    off = np.linalg.norm(places - reference @ places[:, ends], axis=2).max(axis=1)
    return np.asarray(off <= _AFFINE * np.ptp(places, axis=1).max(axis=1))


def _among(rows: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Bool (row,): whether a row of ascending numbers is one of others."""
    size = 1 + max(rows.max(initial=0), others.max(initial=0))
    weights = size ** np.arange(rows.shape[1], dtype=np.int64)
    return np.asarray(np.isin(rows.astype(np.int64) @ weights, others.astype(np.int64) @ weights))
