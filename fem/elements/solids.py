"""Linear elasticity of solids: stiffness, consistent mass, rigid body modes, mass properties.

    K = int B^T C B dV = lambda G_ij + mu (G_ji + delta_ij G_kk),   G_ij[a, b] = int d phi_a/dx_i d phi_b/dx_j dV
    M = int rho phi_a phi_b dV (consistent)

Elements, their order of nodes and their quadrature are those of `fem.elements.solid_elements`; unknowns are numbered
3 node + axis. Straight tetrahedra get the exact mass.

Reference: Zienkiewicz & Taylor, The Finite Element Method, vol. 1, 5th ed. (2000), sections 8.8 and 9.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy.sparse as sp

from fem.elements.cubic import CubicFunctions
from fem.elements.solid_elements import AXES, ElementError, cells, rule, shapes, solid_element


def lame(elastic_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """Lame constants (lambda, mu) in Pa of an isotropic solid."""
    mu = elastic_modulus / (2.0 * (1.0 + poisson_ratio))
    return elastic_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio)), mu


def assemble(
    nodes: np.ndarray,
    elements: np.ndarray,
    *,
    elastic_modulus: float,
    poisson_ratio: float,
    density: float,
    cubic: CubicFunctions | None = None,
    chosen: np.ndarray | None = None,
) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Stiffness and consistent mass of a free body.

    Parameters
    ----------
    nodes : float (node, 3), m
    elements : int (element, k) of one of `fem.elements.solid_elements.SOLIDS`, every node used
    elastic_modulus, poisson_ratio, density : Pa, 1, kg/m3
    cubic : functions of their sides and faces, whose unknowns follow those of the nodes
    chosen : numbers of the elements that contribute; all by default

    Returns
    -------
    K, M : sparse (3 function, 3 function), symmetric, N/m and kg; nodes are the first functions

    Raises
    ------
    ElementError : inverted element (with its position), node without element
    """
    from fem.elements import assembly

    lam, mu = lame(elastic_modulus, poisson_ratio)
    nodes, elements = np.asarray(nodes, float), np.asarray(elements)
    count = len(nodes)
    if (loose := np.setdiff1d(np.arange(count), elements)).size:
        raise ElementError(f"{loose.size} nodes belong to no element, the first is node {int(loose[0])}; remove them")
    chosen = np.arange(len(elements)) if chosen is None else chosen
    own = elements[chosen]
    if cubic is not None:
        number = cubic.moving_numbers(chosen)
        own = np.hstack([own, np.where(number < 0, -1, count + number)])
        count += int(cubic.moving.sum())
    own = own.astype(np.int32)
    indptr, indices = assembly.pattern(own, count)
    K, M = assembly.three_each(indptr, indices)
    parts = [(0, _products(nodes, elements[chosen]))]
    if cubic is not None:
        parts.append((elements.shape[1], cubic.products(chosen)))
    for known, several in parts:
        for members, products, masses in several:
            of_part = np.ascontiguousarray(own[members, : masses.shape[1]])
            assembly.add_elements(of_part, known, products, masses, lam, mu, indptr, indices, K.data, M.data)
    M.data *= density
    return K, M


def _products(nodes: np.ndarray, elements: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Numbers, gradient products G_ij (6, e, k, k) in m by `AXES`, masses of unit density (e, k, k) in m3, in parts."""
    kind = solid_element(elements)
    points, weights = rule(kind.library, 2 * kind.degree)
    values, _ = shapes(kind.library, points)
    of_unit_volume = values.T @ (weights[:, None] * values) / weights.sum()
    for cell in cells(nodes, elements):
        gradients = cell.gradients()
        scaled = (gradients * cell.volume[:, :, None, None]).transpose(3, 0, 2, 1)
        products = np.stack([scaled[i] @ gradients[..., j] for i, j in AXES])
        if cell.affine:
            mass = cell.volume.sum(axis=1)[:, None, None] * of_unit_volume
        else:
            mass = (cell.volume[:, None, :] * cell.values.T) @ cell.values
        yield cell.numbers, products, mass


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
