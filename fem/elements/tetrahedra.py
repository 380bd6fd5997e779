"""Linear elasticity on ten-node tetrahedra: stiffness, consistent mass, rigid body modes, mass properties.

    K = int B^T C B dV = lambda G_ij + mu (G_ji + delta_ij G_kk),   G_ij[a, b] = int d phi_a/dx_i d phi_b/dx_j dV
    M = int rho phi_a phi_b dV (consistent)

Node order of an element: corners 0-3, then the mid-sides of edges 01 12 02 03 13 23 (the order of VTK and
scikit-fem). Unknowns are numbered 3 node + axis. Elements with straight sides take the four-point rule (exact
for K) and the exact mass; curved ones take a rule of degree 7.

Reference: Zienkiewicz & Taylor, The Finite Element Method, vol. 1, 5th ed. (2000), sections 8.8 and 9.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

EDGES = np.array([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)])
_CHUNK = 4096  # elements worked on at once: bounds the memory of the element loop
_STRAIGHT = 1e-9  # a mid-side node this close to the middle of its edge (in edge lengths) counts as straight


class ElementError(ValueError):
    """An element is inverted, or a material constant is outside its physical range."""


def lame(elastic_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """Lame constants (lambda, mu) in Pa of an isotropic solid; 0 < E, -1 < nu < 0.5 or `ElementError`."""
    if not (np.isfinite(elastic_modulus) and elastic_modulus > 0.0):
        raise ElementError(f"elastic modulus is {elastic_modulus!r} Pa; give a positive, finite value")
    if not -1.0 < poisson_ratio < 0.5:
        raise ElementError(f"Poisson ratio is {poisson_ratio!r}; the limits of an isotropic solid are -1 < nu < 0.5")
    mu = elastic_modulus / (2.0 * (1.0 + poisson_ratio))
    return elastic_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio)), mu


def shape_values(points: np.ndarray) -> np.ndarray:
    """Quadratic shape functions at reference points (q, 3) -> (q, 10)."""
    corner = np.column_stack([1.0 - points.sum(axis=1), points])
    first, second = EDGES.T
    return np.hstack([corner * (2.0 * corner - 1.0), 4.0 * corner[:, first] * corner[:, second]])


def shape_gradients(points: np.ndarray) -> np.ndarray:
    """Derivatives of the shape functions with respect to the reference coordinates, (q, 3) -> (q, 10, 3)."""
    corner = np.column_stack([1.0 - points.sum(axis=1), points])
    slope = np.vstack([-np.ones(3), np.eye(3)])  # d corner / d reference
    first, second = EDGES.T
    vertices = (4.0 * corner - 1.0)[:, :, None] * slope
    edges = 4.0 * (corner[:, first, None] * slope[second] + corner[:, second, None] * slope[first])
    return np.concatenate([vertices, edges], axis=1)


def four_point_rule() -> tuple[np.ndarray, np.ndarray]:
    """Points (4, 3) and weights (4,) on the unit tetrahedron, exact to degree 2 (Hammer & Stroud, 1956)."""
    near, far = (5.0 + 3.0 * np.sqrt(5.0)) / 20.0, (5.0 - np.sqrt(5.0)) / 20.0
    points = np.full((4, 3), far)
    points[[1, 2, 3], [0, 1, 2]] = near
    return points, np.full(4, 1.0 / 24.0)


def conical_rule(n: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Jacobi product rule on the unit tetrahedron, n^3 points, exact to degree 2n - 1 (Stroud, 1971)."""
    from scipy.special import roots_jacobi

    (a, wa), (b, wb), (c, wc) = (roots_jacobi(n, power, 0.0) for power in (2.0, 1.0, 0.0))
    a, b, c = (a + 1.0) / 2.0, (b + 1.0) / 2.0, (c + 1.0) / 2.0
    x, y, z = np.meshgrid(a, b, c, indexing="ij")
    weights = np.einsum("i,j,k->ijk", wa / 8.0, wb / 4.0, wc / 2.0)
    points = np.stack([x, y * (1.0 - x), z * (1.0 - x) * (1.0 - y)], axis=-1)
    return points.reshape(-1, 3), weights.ravel()


def curved(nodes: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Bool (element,): a mid-side node lies off the middle of its straight edge."""
    corners = nodes[elements[:, :4]]
    start, end = corners[:, EDGES[:, 0]], corners[:, EDGES[:, 1]]
    off = np.linalg.norm(nodes[elements[:, 4:]] - 0.5 * (start + end), axis=2)
    return (off > _STRAIGHT * np.linalg.norm(end - start, axis=2)).any(axis=1)


def _physical(coordinates: np.ndarray, gradients: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gradients (e, q, 10, 3) in space and Jacobian determinants (e, q) of elements with `coordinates` (e, 10, 3)."""
    jacobian = np.einsum("ead,qar->eqdr", coordinates, gradients, optimize=True)  # dx_d / d reference_r
    determinant = np.linalg.det(jacobian)
    if (bad := determinant <= 0.0).any():
        worst = int(np.argmin(determinant.min(axis=1)))
        x, y, z = coordinates[worst, :4].mean(axis=0)
        raise ElementError(
            f"{int(bad.any(axis=1).sum())} tetrahedra are inverted (Jacobian <= 0); the worst is element "
            f"{int(places[worst])} near ({x:.4g}, {y:.4g}, {z:.4g}) m with {determinant.min():.3g} m3. "
            "Use a smaller element size, straight sides, or check the order of the nodes"
        )
    return np.einsum("qar,eqrd->eqad", gradients, np.linalg.inv(jacobian), optimize=True), determinant


@dataclass(frozen=True)
class _Pattern:
    """Where element entries land in the node-by-node sparse matrix."""

    n: int
    slot: np.ndarray  # (element * 100,) position in the data of the sparse matrix
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
        """Sum of the element entries (element, 10, 10) that share a place in the matrix."""
        return np.bincount(self.slot, weights=entries.ravel(), minlength=self.indices.size)


def assemble(
    nodes: np.ndarray, elements: np.ndarray, *, elastic_modulus: float, poisson_ratio: float, density: float
) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Stiffness and consistent mass of a free body.

    Parameters
    ----------
    nodes : float (node, 3), m
    elements : int (element, 10), every node used
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
    products, mass = np.empty((3, 3, len(elements), 10, 10)), np.empty((len(elements), 10, 10))
    is_curved = curved(nodes, elements)
    for group, rule in ((np.flatnonzero(~is_curved), four_point_rule()), (np.flatnonzero(is_curved), conical_rule())):
        _element_loop(nodes, elements, group, rule, products, mass)
    blocks = np.zeros((pattern.indices.size, 3, 3))
    trace = mu * pattern.sum(products[0, 0] + products[1, 1] + products[2, 2])
    for i in range(3):
        for j in range(i, 3):
            gradient = products[i, j] * lam + products[j, i] * mu
            blocks[:, i, j] = pattern.sum(gradient)
            blocks[:, j, i] = blocks[:, i, j] if i == j else pattern.sum(products[j, i] * lam + products[i, j] * mu)
        blocks[:, i, i] += trace
    shape = (3 * n, 3 * n)
    stiffness = sp.bsr_matrix((blocks, pattern.indices, pattern.indptr), shape=shape).tocsr()
    scalar = sp.csr_matrix((density * pattern.sum(mass), pattern.indices, pattern.indptr), shape=(n, n))
    return stiffness, sp.kron(scalar, sp.eye_array(3), format="csr")


def _element_loop(
    nodes: np.ndarray,
    elements: np.ndarray,
    group: np.ndarray,
    rule: tuple[np.ndarray, np.ndarray],
    products: np.ndarray,
    mass: np.ndarray,
) -> None:
    """Fill gradient products (3, 3, e, 10, 10) and unit-density mass (e, 10, 10) of the elements in `group`."""
    points, weights = rule
    gradients, values = shape_gradients(points), shape_values(points)
    straight_sided = len(weights) == 4
    fine_points, fine_weights = conical_rule(3)
    fine = shape_values(fine_points)
    unit_mass = 6.0 * np.einsum("q,qa,qb->ab", fine_weights, fine, fine)  # of a straight element with volume 1
    chunk = _CHUNK if straight_sided else _CHUNK // 16
    for start in range(0, len(group), chunk):
        part = group[start : start + chunk]
        slope, determinant = _physical(nodes[elements[part]], gradients, part)
        scaled = slope * (determinant * weights)[:, :, None, None]
        for i in range(3):
            left = np.ascontiguousarray(scaled[..., i].transpose(0, 2, 1))
            for j in range(3):
                products[i, j, part] = left @ slope[..., j]
        if straight_sided:
            mass[part] = (determinant @ weights)[:, None, None] * unit_mass
        else:
            mass[part] = np.einsum("eq,qa,qb->eab", determinant * weights, values, values, optimize=True)


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
    is_curved = curved(nodes, elements)
    for group, rule in ((elements[~is_curved], four_point_rule()), (elements[is_curved], conical_rule())):
        points, weights = rule
        gradients, values = shape_gradients(points), shape_values(points)
        for start in range(0, len(group), _CHUNK // 8):
            coordinates = nodes[group[start : start + _CHUNK // 8]]
            determinant = np.linalg.det(np.einsum("ead,qar->eqdr", coordinates, gradients, optimize=True))
            place = np.einsum("qa,ead->eqd", values, coordinates, optimize=True)
            place = np.concatenate([np.ones((*place.shape[:2], 1)), place], axis=2).reshape(-1, 4)
            moment += place.T @ (place * (determinant * weights).reshape(-1, 1))
    mass, centre = density * moment[0, 0], moment[0, 1:] / moment[0, 0]
    second = density * moment[1:, 1:] - mass * np.outer(centre, centre)
    return float(mass), centre, np.trace(second) * np.eye(3) - second
