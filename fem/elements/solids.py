"""Linear elasticity of solids: stiffness, consistent mass, rigid body modes, mass properties.

    K = int B^T C B dV = lambda G_ij + mu (G_ji + delta_ij G_kk),   G_ij[a, b] = int d phi_a/dx_i d phi_b/dx_j dV
    M = int rho phi_a phi_b dV (consistent)

Elements, their order of nodes and their quadrature are those of `fem.elements.solid_elements`; unknowns are numbered
3 node + axis. Straight tetrahedra get the exact mass.

Reference: Zienkiewicz & Taylor, The Finite Element Method, vol. 1, 5th ed. (2000), sections 8.8 and 9.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fem.elements.solid_elements import ElementError, cells, rule, shapes, solid_element


def lame(elastic_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """Lame constants (lambda, mu) in Pa of an isotropic solid; 0 < E, -1 < nu < 0.5 or `ElementError`."""
    if not (np.isfinite(elastic_modulus) and elastic_modulus > 0.0):
        raise ElementError(f"elastic modulus is {elastic_modulus!r} Pa; give a positive, finite value")
    if not -1.0 < poisson_ratio < 0.5:
        raise ElementError(f"Poisson ratio is {poisson_ratio!r}; the limits of an isotropic solid are -1 < nu < 0.5")
    mu = elastic_modulus / (2.0 * (1.0 + poisson_ratio))
    return elastic_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio)), mu


_AXES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # i, j of the products that are kept: G_ji is G_ij turned


@dataclass(frozen=True)
class _Pattern:
    """Where element entries land in the node-by-node sparse matrix."""

    n: int
    slot: np.ndarray  # (element * k * k,) position in the data of the sparse matrix
    indices: np.ndarray
    indptr: np.ndarray

    @classmethod
    def of(cls, n: int, elements: np.ndarray) -> _Pattern:
        key = (elements[:, :, None].astype(np.int64) * n + elements[:, None, :]).ravel()
        unique, slot = np.unique(key, return_inverse=True)
        rows = unique // n
        indptr = np.searchsorted(rows, np.arange(n + 1)).astype(np.int32)
        return cls(n, slot, (unique - rows * n).astype(np.int32), indptr)

    def sum(self, entries: np.ndarray) -> np.ndarray:
        """Sum of the element entries (element, k, k) that share a place in the matrix."""
        return np.bincount(self.slot, weights=entries.ravel(), minlength=self.indices.size)


def assemble(
    nodes: np.ndarray, elements: np.ndarray, *, elastic_modulus: float, poisson_ratio: float, density: float
) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Stiffness and consistent mass of a free body.

    Parameters
    ----------
    nodes : float (node, 3), m
    elements : int (element, k) of one of `fem.elements.solid_elements.SOLIDS`, every node used
    elastic_modulus, poisson_ratio, density : Pa, 1, kg/m3

    Returns
    -------
    K, M : sparse (3 node, 3 node), symmetric, N/m and kg

    Raises
    ------
    ElementError : inverted element (with its place), material outside its range, node without element
    """
    lam, mu = lame(elastic_modulus, poisson_ratio)
    if not (np.isfinite(density) and density > 0.0):
        raise ElementError(f"density is {density!r} kg/m3; give a positive, finite value")
    nodes, elements = np.asarray(nodes, float), np.asarray(elements)
    n = len(nodes)
    if (loose := np.setdiff1d(np.arange(n), elements)).size:
        raise ElementError(f"{loose.size} nodes belong to no element, the first is node {int(loose[0])}; remove them")
    pattern = _Pattern.of(n, elements)
    products, mass = _products(nodes, elements)
    blocks = np.zeros((pattern.indices.size, 3, 3))
    blocks[:, [0, 1, 2], [0, 1, 2]] = mu * pattern.sum(products[:3].sum(axis=0))[:, None]
    for (i, j), product in zip(_AXES, products, strict=True):
        turned = product.transpose(0, 2, 1)  # G_ji
        blocks[:, i, j] += pattern.sum(lam * product + mu * turned)
        if i != j:
            blocks[:, j, i] = pattern.sum(lam * turned + mu * product)
    shape = (3 * n, 3 * n)
    stiffness = sp.bsr_matrix((blocks, pattern.indices, pattern.indptr), shape=shape).tocsr()
    scalar = sp.csr_matrix((density * pattern.sum(mass), pattern.indices, pattern.indptr), shape=(n, n))
    return stiffness, sp.kron(scalar, sp.eye_array(3), format="csr")


def _products(nodes: np.ndarray, elements: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gradient products G_ij (6, e, k, k) in m by `_AXES`, masses of unit density (e, k, k) in m3, of all elements."""
    kind = solid_element(elements)
    shape = (len(elements), kind.nodes, kind.nodes)
    products, mass = np.empty((len(_AXES), *shape)), np.empty(shape)
    points, weights = rule(kind.library, 2 * kind.degree)
    values, _ = shapes(kind.library, points)
    of_unit_volume = values.T @ (weights[:, None] * values) / weights.sum()
    for cell in cells(nodes, elements):
        gradients = cell.gradients()
        scaled = (gradients * cell.volume[:, :, None, None]).transpose(3, 0, 2, 1)
        for place, (i, j) in enumerate(_AXES):
            products[place, cell.numbers] = scaled[i] @ gradients[..., j]
        if cell.affine:
            mass[cell.numbers] = cell.volume.sum(axis=1)[:, None, None] * of_unit_volume
        else:
            mass[cell.numbers] = np.einsum("eq,qa,qb->eab", cell.volume, cell.values, cell.values, optimize=True)
    return products, mass


def rigid_body_modes(nodes: np.ndarray, centre: np.ndarray | None = None) -> np.ndarray:
    """Three unit translations and three unit rotations about `centre` (origin by default), (3 node, 6).

    u = t + r x (x - centre): exact zero-energy motions of the element.
    """
    x, y, z = (np.asarray(nodes, float) - (np.zeros(3) if centre is None else centre)).T
    modes = np.zeros((len(x), 3, 6))
    modes[:, [0, 1, 2], [0, 1, 2]] = 1.0
    modes[:, 1, 3], modes[:, 2, 3] = -z, y
    modes[:, 0, 4], modes[:, 2, 4] = z, -x
    modes[:, 0, 5], modes[:, 1, 5] = -y, x
    return modes.reshape(-1, 6)


def mass_properties(nodes: np.ndarray, elements: np.ndarray, density: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass (kg), centre of gravity (3,) (m) and inertia tensor about it (3, 3) (kg m2) by integration over the mesh."""
    moment = np.zeros((4, 4))  # integral of [1, x]^T [1, x] dV
    for cell in cells(nodes, elements):
        place = np.concatenate([np.ones((1, *cell.volume.shape)), cell.places()]).reshape(4, -1)
        moment += (place * cell.volume.ravel()) @ place.T
    mass, centre = density * moment[0, 0], moment[0, 1:] / moment[0, 0]
    second = density * moment[1:, 1:] - mass * np.outer(centre, centre)
    return float(mass), centre, np.trace(second) * np.eye(3) - second
