"""Stiffness and mass of tetrahedra with 20 nodes: cubic displacements on the geometry of ten-node ones.

    K_ij = int lambda d_i phi_a d_j phi_b + mu (d_j phi_a d_i phi_b + delta_ij d_k phi_a d_k phi_b) dV

Nodes: the corners, two on every side, one in the middle of every face. The shape functions are those combinations of
the 20 monomials of degree three in the barycentric coordinates that are one at their own node and zero at all others
(Zienkiewicz & Taylor, The Finite Element Method, vol. 1, 5th ed. (2000), section 8.12).
"""

from __future__ import annotations

import itertools

import numpy as np
import scipy.sparse as sp

from benchmarks.casing_limits.graded import PLACES, SIDES, TEN
from fem.elements.materials import Material
from fem.elements.solid_elements import CURVED_RULE, ElementError, curved, rule, shapes
from fem.elements.solids import lame

NODES = 20
_FACES = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])
_RULE = {False: CURVED_RULE - 2, True: CURVED_RULE}  # by whether an element is curved; straight: exact to degree 6
_CHUNK = 40000  # quadrature points worked on at once
_POWERS = np.array([one for one in itertools.product(range(4), repeat=4) if sum(one) == 3])  # (20, 4)
_OF_PLACE = np.linalg.inv(np.column_stack([PLACES[:4], np.ones(4)]))  # barycentric coordinates: [x, 1] @ this


def _nodes() -> np.ndarray:
    """Barycentric coordinates (20, 4)."""
    at = np.zeros((NODES, 4))
    at[:4] = np.eye(4)
    for number, (i, j) in enumerate(SIDES):
        at[4 + 2 * number : 6 + 2 * number, [i, j]] = [[2 / 3, 1 / 3], [1 / 3, 2 / 3]]
    for number, face in enumerate(_FACES):
        at[16 + number, face] = 1 / 3
    return at


_AT = _nodes()
_COEFFICIENTS = np.linalg.inv(np.prod(_AT[:, None, :] ** _POWERS, axis=2))  # (monomial, node)


def cubic_shapes(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Shape functions (q, 20) and their local derivatives (q, 20, 3) at points (3, q)."""
    at = np.column_stack([points.T, np.ones(points.shape[1])]) @ _OF_PLACE
    values = np.prod(at[:, None, :] ** _POWERS, axis=2) @ _COEFFICIENTS
    slopes = np.zeros((*values.shape, 3))
    for number in range(4):
        lower = _POWERS.copy()
        lower[:, number] = np.maximum(lower[:, number] - 1, 0)
        monomials = _POWERS[:, number] * np.prod(at[:, None, :] ** lower, axis=2)
        slopes += (monomials @ _COEFFICIENTS)[:, :, None] * _OF_PLACE[:3, number]
    return values, slopes


def numbered(elements: np.ndarray) -> tuple[np.ndarray, int]:
    """Numbers (e, 20) of the cubic nodes of ten-node elements, and how many there are."""
    used, own = np.unique(elements[:, :4], return_inverse=True)
    corners = own.reshape(-1, 4)
    sides, side = np.unique(np.sort(corners[:, SIDES], axis=2).reshape(-1, 2), axis=0, return_inverse=True)
    faces, face = np.unique(np.sort(corners[:, _FACES], axis=2).reshape(-1, 3), axis=0, return_inverse=True)
    backwards = corners[:, SIDES[:, 0]] > corners[:, SIDES[:, 1]]  # the first of two nodes is next to the lower number
    first = len(used) + 2 * side.reshape(-1, 6)
    both = np.stack([first + backwards, first + ~backwards], axis=2).reshape(-1, 12)
    before = len(used) + 2 * len(sides)
    return np.column_stack([corners, both, before + face.reshape(-1, 4)]), before + len(faces)


def cubic_matrices(
    nodes: np.ndarray, elements: np.ndarray, material: Material
) -> tuple[np.ndarray, sp.csr_matrix, sp.csr_matrix]:
    """Places (n, 3) of the cubic nodes, stiffness and mass (3 n, 3 n) of a free body.

    Parameters
    ----------
    nodes, elements : ten-node tetrahedra, (m, 3) m and (e, 10)
    material : of all of them

    Raises
    ------
    ElementError : an element is inverted
    """
    numbers, n = numbered(elements)
    lam, mu = lame(material.elastic_modulus, material.poisson_ratio)
    key, slot = np.unique(numbers[:, :, None] * n + numbers[:, None, :], return_inverse=True)
    rows, columns = np.divmod(key, n)
    pattern = (columns.astype(np.int32), np.searchsorted(rows, np.arange(n + 1)).astype(np.int32))
    slot = slot.reshape(len(numbers), -1)
    blocks, mass, bent = np.zeros((3, 3, len(key))), np.zeros(len(key)), curved(nodes, elements)
    for kind, degree in _RULE.items():
        points, weights = rule(TEN.library, degree)
        (values, slopes), (_, of_map) = cubic_shapes(points), shapes(TEN.library, points)
        members = np.flatnonzero(bent == kind)
        for part in np.array_split(members, -(-len(members) * len(weights) // _CHUNK) or 1):
            jacobian = np.einsum("qar,ead->eqdr", of_map, nodes[elements[part]])
            determinant = np.linalg.det(jacobian)
            if (bad := (determinant <= 0.0).any(axis=1)).any():
                raise ElementError(f"{int(bad.sum())} of {len(part)} elements are inverted; use smaller ones")
            volume = determinant * weights
            gradient = np.einsum("qar,eqrd->deqa", slopes, np.linalg.inv(jacobian), optimize=True)
            scaled = (gradient * volume[:, :, None]).transpose(0, 1, 3, 2)
            where = slot[part].ravel()
            shear = mu * sum(scaled[k] @ gradient[k] for k in range(3))
            for i, j in itertools.product(range(3), repeat=2):
                product = scaled[i] @ gradient[j]
                entries = lam * product + mu * product.transpose(0, 2, 1) + (shear if i == j else 0.0)
                blocks[i, j] += np.bincount(where, weights=entries.ravel(), minlength=len(key))
            entries = (volume[:, None, :] * values.T) @ values
            mass += np.bincount(where, weights=entries.ravel(), minlength=len(key))
    shape = (3 * n, 3 * n)
    stiffness = sp.bsr_matrix((np.ascontiguousarray(blocks.transpose(2, 0, 1)), *pattern), shape=shape).tocsr()
    scalar = sp.csr_matrix((material.density * mass, *pattern), shape=(n, n))
    places = np.empty((n, 3))
    at, _ = shapes(TEN.library, (_AT @ PLACES[:4]).T)
    places[numbers] = np.einsum("qa,ead->eqd", at, nodes[elements])
    return places, stiffness, sp.kron(scalar, sp.eye_array(3), format="csr")
