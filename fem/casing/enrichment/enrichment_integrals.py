"""Compiled integration over an element of the functions added to it, for their stiffness and mass.

Loops evaluate the functions at every point; matrix products then sum over the points.
"""

from __future__ import annotations

import numpy as np

from fem.numerics.compiled import stored

_POINTS = 512  # evaluated together, so that their values fit in the processor's cache


def added_entries(
    nodes: np.ndarray,
    *,
    values: np.ndarray,
    slopes: np.ndarray,
    weights: np.ndarray,
    tables: np.ndarray,
    lines: np.ndarray,
    owners: np.ndarray,
    axes: np.ndarray,
    frames: np.ndarray,
    lame: tuple[float, float],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Stiffness and mass that couple the added functions with those of the element and with one another.

    Parameters
    ----------
    nodes : (n, 3), m, of the element
    values, slopes, weights : (a, q), (a, 3, q) and (q,), functions of the element, nodal ones first, their derivatives
        by the reference coordinates, and the weights of the points
    tables : (f, 3, 3, q), an added function across the edge and its derivatives by xi and eta, three components each
    lines : (p, 2, q), the function of a node along the edge and its derivative
    owners : int (f,), the node of every added function
    axes, frames : (p, 3, 3) of the nodes; columns: directions of xi, eta, s in the element, and of the components in
        space
    lame : Lame constants lambda and mu, Pa

    Returns
    -------
    stiffness with the element's functions (f, 3, a) and among the added ones (f, f), then mass of unit density likewise
    """
    a, f, count = len(values), len(owners), len(weights)
    K_nodes, M_nodes = np.zeros((2, f, 3, a))
    K_own, M_own = np.zeros((2, f, f))
    for first in range(0, count, _POINTS):
        end = min(first + _POINTS, count)
        inverse, volume = _inverse(nodes, slopes, weights, first, end)
        of_nodes = np.einsum("arq,rdq->adq", slopes[..., first:end], inverse)
        moved, strains, stresses = _laid_out(tables, lines, owners, axes, frames, inverse, *lame, first, end)
        stresses *= volume
        weighed = moved * volume
        K_nodes += (stresses.reshape(3 * f, -1) @ of_nodes.reshape(a, -1).T).reshape(f, 3, a)
        M_nodes += (weighed.reshape(3 * f, -1) @ values[:, first:end].T).reshape(f, 3, a)
        K_own += strains.reshape(f, -1) @ stresses.reshape(f, -1).T
        M_own += moved.reshape(f, -1) @ weighed.reshape(f, -1).T
    return K_nodes, K_own, M_nodes, M_own


@stored(__file__)
def _inverse(nodes, slopes, weights, first, end):
    """Derivatives (3, 3, q) of the reference coordinates (rows) by position, and the volume (q,) of every point."""
    J, inverse, volume = np.zeros((3, 3, end - first)), np.empty((3, 3, end - first)), np.zeros(end - first)
    for a in range(len(nodes)):
        for d in range(3):
            for r in range(3):
                for q in range(end - first):
                    J[d, r, q] += nodes[a, d] * slopes[a, r, first + q]
    for d in range(3):
        e, h = (d + 1) % 3, (d + 2) % 3
        for r in range(3):
            t, u = (r + 1) % 3, (r + 2) % 3
            for q in range(end - first):
                inverse[r, d, q] = J[e, t, q] * J[h, u, q] - J[e, u, q] * J[h, t, q]
    for r in range(3):
        for q in range(end - first):
            volume[q] += J[0, r, q] * inverse[r, 0, q]
    for r in range(3):
        for d in range(3):
            for q in range(end - first):
                inverse[r, d, q] /= volume[q]
    for q in range(end - first):
        volume[q] *= weights[first + q]
    return inverse, volume


@stored(__file__)
def _laid_out(tables, lines, owners, axes, frames, inverse, lam, mu, first, end):
    """Displacements (f, 3, q), their gradients and stresses (f, 3, 3, q) of the added functions."""
    f_count, q_count, part = len(owners), end - first, -1
    moved, strains = np.empty((f_count, 3, q_count)), np.empty((f_count, 3, 3, q_count))
    stresses, local = np.empty((f_count, 3, 3, q_count)), np.empty((3, q_count))
    turned = np.empty((3, 3, q_count))  # derivatives of xi, eta, s by position, times the function along the edge
    for f in range(f_count):
        if owners[f] != part:
            part = owners[f]
            for k in range(3):
                x, y, z = axes[part, :, k]
                for d in range(3):
                    for q in range(q_count):
                        along = lines[part, k // 2, first + q]
                        turned[k, d, q] = along * (x * inverse[0, d, q] + y * inverse[1, d, q] + z * inverse[2, d, q])
        for c in range(3):
            x, y, z = frames[part, c]
            for k in range(3):
                for q in range(q_count):
                    at = first + q
                    local[k, q] = x * tables[f, k, 0, at] + y * tables[f, k, 1, at] + z * tables[f, k, 2, at]
            for q in range(q_count):
                moved[f, c, q] = lines[part, 0, first + q] * local[0, q]
            for d in range(3):
                for q in range(q_count):
                    across = turned[0, d, q] * local[1, q] + turned[1, d, q] * local[2, q]
                    strains[f, c, d, q] = across + turned[2, d, q] * local[0, q]
        for c in range(3):
            for d in range(3):
                for q in range(q_count):
                    stresses[f, c, d, q] = mu * (strains[f, c, d, q] + strains[f, d, c, q])
        for q in range(q_count):
            pressure = lam * (strains[f, 0, 0, q] + strains[f, 1, 1, q] + strains[f, 2, 2, q])
            for c in range(3):
                stresses[f, c, c, q] += pressure
    return moved, strains, stresses
