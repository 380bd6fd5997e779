"""Hierarchical cubic functions of tetrahedra and hexahedra, added to those of the quadratic element.

    side i j:            6 sqrt(3) l_i l_j (l_i - l_j)        of hexahedra times the linear functions across the side
    face i j k:          27 l_i l_j l_k                       of tetrahedra

l are the barycentric coordinates of a tetrahedron, and 1 - t and t along the side of a hexahedron. All have the largest
value 1 and vanish at all nodes. With the quadratic functions they span the cubics of a tetrahedron, and the serendipity
space of degree three of a hexahedron (that of the 32-node element).

References: Szabo & Babuska (1991), Finite Element Analysis, section 13.2 (hierarchic functions of tetrahedra and
hexahedra); Arnold & Awanou (2011), Found. Comput. Math. 11(3), 337-344 (serendipity spaces).
"""

from __future__ import annotations

import itertools
import math
from functools import cache

import numpy as np

from fem.elements.solid_elements import SOLIDS, SolidElement, shapes

_OF_SIDE, _OF_FACE = 6.0 * math.sqrt(3.0), 27.0


@cache
def sides_of(kind: SolidElement) -> np.ndarray:
    """Local corners (side, 2) at the ends of the sides with functions."""
    return np.array(kind.library.refdom.edges)


@cache
def faces_of(kind: SolidElement) -> np.ndarray:
    """Local corners (face, 3) of the faces that have functions: none in hexahedra."""
    return np.array(list(itertools.combinations(range(4), 3)) if kind.corners == 4 else np.zeros((0, 3)), int)


def cubic_shapes(kind: SolidElement, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Functions of nodes, sides and faces (q, a) and their local derivatives (q, a, 3) at points (3, q)."""
    values, slopes = shapes(kind.library, points)
    added, by = (_of_tetrahedra if kind.corners == 4 else _of_hexahedra)(kind, points)
    return np.column_stack([values, added]), np.concatenate([slopes, by], axis=1)


def _of_tetrahedra(kind: SolidElement, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    of_place = np.linalg.inv(np.column_stack([kind.library.doflocs[:4], np.ones(4)]))  # l = [x, 1] @ this
    at = np.column_stack([points.T, np.ones(points.shape[1])]) @ of_place
    sides, faces = sides_of(kind), faces_of(kind)
    values, by = np.empty((len(at), 10)), np.zeros((len(at), 10, 4))
    for number, (i, j) in enumerate(sides):
        values[:, number], by[:, number, i], by[:, number, j] = _along(at[:, i], at[:, j])
    for number, (i, j, k) in enumerate(faces, len(sides)):
        a, b, c = at[:, i], at[:, j], at[:, k]
        values[:, number] = _OF_FACE * a * b * c
        by[:, number, i], by[:, number, j], by[:, number, k] = _OF_FACE * b * c, _OF_FACE * a * c, _OF_FACE * a * b
    return values, by @ of_place[:3].T


def _of_hexahedra(kind: SolidElement, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    sides, corners = sides_of(kind), kind.library.doflocs
    values, slopes = np.empty((points.shape[1], len(sides))), np.empty((points.shape[1], len(sides), 3))
    for number, (i, j) in enumerate(sides):
        axis = int(abs(corners[j] - corners[i]).argmax())
        first, second = (one for one in range(3) if one != axis)
        a, by_a = _linear(points[axis], corners[i, axis])
        b, by_b = _linear(points[axis], corners[j, axis])
        u, by_u = _linear(points[first], corners[i, first])
        v, by_v = _linear(points[second], corners[i, second])
        value, of_a, of_b = _along(a, b)
        values[:, number] = value * u * v
        slopes[:, number, axis] = (of_a * by_a + of_b * by_b) * u * v
        slopes[:, number, first] = value * by_u * v
        slopes[:, number, second] = value * u * by_v
    return values, slopes


def _along(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The function of a side and its derivatives by both coordinates."""
    return _OF_SIDE * a * b * (a - b), _OF_SIDE * b * (2.0 * a - b), _OF_SIDE * a * (a - 2.0 * b)


def _linear(x: np.ndarray, end: float) -> tuple[np.ndarray, float]:
    """The linear function along an axis with value 1 at an end (0 or 1), and its slope."""
    return (x, 1.0) if end > 0.5 else (1.0 - x, -1.0)


def element_shapes(kind: SolidElement, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All functions of an element (q, a) and their local derivatives (q, a, 3) at points (3, q)."""
    return cubic_shapes(kind, points) if kind.degree == 3 else shapes(kind.library, points)


CUBIC = {one.nodes: one for one in SOLIDS.values() if one.degree == 3}  # by the nodes of their geometry
