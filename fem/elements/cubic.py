"""Cubic displacements in ten-node tetrahedra, by functions that are added to the quadratic ones.

    side i j:       6 sqrt(3) l_i l_j (l_i - l_j)        face i j k:       27 l_i l_j l_k

with the barycentric coordinates l; both reach 1 and vanish at all ten nodes. Along a side i is the node with the lower
number, so that neighbours have one function. One tetrahedron through a wall then bends and shears as a plate does: its
displacements across the wall are cubic. The geometry stays that of ten nodes.

Reference: Szabo & Babuska (1991), Finite Element Analysis, section 13.2 (hierarchic functions of tetrahedra).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fem.elements.added_unknowns import AddedUnknowns
from fem.elements.materials import Material
from fem.elements.solid_elements import CURVED_RULE, SOLIDS, curved, rule, shapes
from fem.elements.solids import lame

_TEN = SOLIDS["tetrahedron-10"].library
_SIDES = np.array(_TEN.refdom.edges)
_FACES = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])
_STRAIGHT_RULE = CURVED_RULE - 2  # exact to degree 6, that of the mass
_OF_PLACE = np.linalg.inv(np.column_stack([_TEN.doflocs[:4], np.ones(4)]))  # l = [x, 1] @ this
_CHUNK = 50000  # quadrature points worked on at once


@dataclass(frozen=True, eq=False)
class CubicFunctions(AddedUnknowns):
    """Three unknowns, along x, y and z, for every side and every face that is not held."""

    points: np.ndarray  # (n, 3), m
    elements: np.ndarray  # (e, 10)
    material: Material
    functions: np.ndarray  # (e, 10), of the six sides and four faces; held ones as well
    moving: np.ndarray  # (function,), bool

    def matrices(self, elements: Collection[int] | None = None) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """As `AddedUnknowns.matrices`; three products of gradients summed over each pair of functions."""
        members = np.arange(len(self.elements)) if elements is None else np.array(sorted(elements), int)
        count = self.nodes + len(self.moving)
        own = np.column_stack([self.elements[members].astype(np.int64), self.nodes + self.functions[members]])
        key, slot = np.unique(own[:, :, None] * count + own[:, None, 10:], return_inverse=True)
        slot = slot.reshape(len(members), -1)
        blocks, masses = np.zeros((len(key), 3, 3)), np.zeros(len(key))
        lam, mu = lame(self.material.elastic_modulus, self.material.poisson_ratio)
        sign = self._signs(members)
        for part, products, mass in _products(self.points, self.elements[members]):
            turn = sign[part][:, :, None] * sign[part][:, None, 10:]
            where = slot[part].ravel()

            def summed(entries: np.ndarray, where: np.ndarray = where, turn: np.ndarray = turn) -> np.ndarray:
                return np.bincount(where, weights=(entries * turn).ravel(), minlength=len(key))

            shear = mu * (products[0, 0] + products[1, 1] + products[2, 2])
            for i, j in itertools.product(range(3), repeat=2):
                entries = lam * products[i, j] + mu * products[j, i]
                blocks[:, i, j] += summed(entries + shear if i == j else entries)
            masses += summed(mass)
        rows, columns = np.divmod(key, count)
        indices, indptr = columns.astype(np.int32), np.searchsorted(rows, np.arange(count + 1)).astype(np.int32)
        stiffness = sp.bsr_matrix((blocks, indices, indptr), shape=(3 * count, 3 * count)).tocsr()
        scalar = sp.csr_matrix((self.material.density * masses, indices, indptr), shape=(count, count))
        return self._both(stiffness), self._both(sp.kron(scalar, sp.eye_array(3), format="csr"))

    def _signs(self, members: np.ndarray) -> np.ndarray:
        """Of all twenty functions (e, 20): -1 where a side runs from the higher number to the lower."""
        ends = self.elements[members][:, _SIDES]
        sign = np.ones((len(members), 20))
        sign[:, 10:16] = np.where(ends[:, :, 0] < ends[:, :, 1], 1.0, -1.0)
        return sign

    def _both(self, columns: sp.csr_matrix) -> sp.csr_matrix:
        """The whole symmetric matrix by its columns of added unknowns, without those that are held."""
        n = 3 * self.nodes
        kept = np.concatenate([np.arange(n), n + np.flatnonzero(np.repeat(self.moving, 3))])
        found = sp.csr_matrix(columns[kept][:, kept])
        return sp.csr_matrix(found + sp.vstack([found[:n], sp.csr_matrix((len(self), len(kept)))]).T)


def cubic_functions(points: np.ndarray, elements: np.ndarray, held: np.ndarray, material: Material) -> CubicFunctions:
    """The functions of all sides and faces of a mesh.

    Parameters
    ----------
    points, elements : (n, 3) m and (e, 10), ten-node tetrahedra
    held : (f, 3 or more), corners first, of facets on which the displacements are those of the nodes: clamped or rigid
    material : of all elements
    """
    corners, held = elements[:, :4], np.sort(held[:, :3], axis=1)
    sides, side = np.unique(np.sort(corners[:, _SIDES], axis=2).reshape(-1, 2), axis=0, return_inverse=True)
    faces, face = np.unique(np.sort(corners[:, _FACES], axis=2).reshape(-1, 3), axis=0, return_inverse=True)
    rims = np.unique(held[:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2), axis=0)
    moving = np.concatenate([~_among(sides, rims), ~_among(faces, np.unique(held, axis=0))])
    places = np.concatenate([points[sides].mean(axis=1), points[faces].mean(axis=1)])[moving]
    return CubicFunctions(
        nodes=len(points),
        numbers=np.tile(np.arange(3), len(places)),
        places=np.repeat(places, 3, axis=0),
        points=points,
        elements=elements,
        material=material,
        functions=np.column_stack([side.reshape(-1, 6), len(sides) + face.reshape(-1, 4)]),
        moving=moving,
    )


def cubic_shapes(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The twenty functions (q, 20), those of the nodes first, and their local derivatives (q, 20, 3) at (3, q)."""
    at = np.column_stack([points.T, np.ones(points.shape[1])]) @ _OF_PLACE
    values, slopes = shapes(_TEN, points)
    added, by = np.empty((len(at), 10)), np.zeros((len(at), 10, 4))
    for number, (i, j) in enumerate(_SIDES):
        a, b = at[:, i], at[:, j]
        added[:, number] = a * b * (a - b)
        by[:, number, i], by[:, number, j] = b * (2.0 * a - b), a * (a - 2.0 * b)
    for number, (i, j, k) in enumerate(_FACES, 6):
        a, b, c = at[:, i], at[:, j], at[:, k]
        added[:, number] = a * b * c
        by[:, number, i], by[:, number, j], by[:, number, k] = b * c, a * c, a * b
    scale = np.repeat([6.0 * math.sqrt(3.0), 27.0], [6, 4])
    return (
        np.column_stack([values, scale * added]),
        np.concatenate([slopes, scale[:, None] * (by @ _OF_PLACE[:3].T)], axis=1),
    )


def _products(points: np.ndarray, elements: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Numbers (p,), int d_i phi_a d_j phi_b dV (3, 3, p, 20, 10) and int phi_a phi_b dV (p, 20, 10), part by part."""
    bent = curved(points, elements)
    for members, degree in ((np.flatnonzero(~bent), _STRAIGHT_RULE), (np.flatnonzero(bent), CURVED_RULE)):
        at, weights = rule(_TEN, degree)
        (values, slopes), (_, of_map) = cubic_shapes(at), shapes(_TEN, at)
        affine = degree == _STRAIGHT_RULE
        masses = np.einsum("q,qa,qb->ab", weights, values, values[:, 10:])
        tensor = np.einsum("q,qar,qbs->rsab", weights, slopes, slopes[:, 10:], optimize=True).reshape(9, -1)
        for part in np.array_split(members, -(-len(members) * len(weights) // _CHUNK)) if len(members) else ():
            places = points[elements[part]]
            if affine:
                jacobian = np.einsum("ar,ead->edr", of_map[0], places)
                volume, inverse = np.linalg.det(jacobian), np.linalg.inv(jacobian)
                pairs = np.einsum("e,eri,esj->ijers", volume, inverse, inverse, optimize=True)
                products = (pairs.reshape(-1, 9) @ tensor).reshape(3, 3, len(part), 20, 10)
                yield part, products, volume[:, None, None] * masses
                continue
            jacobian = np.einsum("qar,ead->eqdr", of_map, places, optimize=True)
            volume = weights * np.linalg.det(jacobian)
            gradient = np.einsum("qar,eqri->ieqa", slopes, np.linalg.inv(jacobian), optimize=True)
            weighted = (gradient * volume[:, :, None]).transpose(0, 1, 3, 2)
            products = weighted[:, None] @ gradient[None, :, :, :, 10:]
            yield part, products, (volume[:, None, :] * values.T) @ values[:, 10:]


def _among(rows: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Bool (row,): whether a row of ascending numbers is one of others."""
    size = 1 + max(rows.max(initial=0), others.max(initial=0))
    weights = size ** np.arange(rows.shape[1], dtype=np.int64)
    return np.asarray(np.isin(rows.astype(np.int64) @ weights, others.astype(np.int64) @ weights))
