"""Stiffness and mass of functions that are added to an element."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def added_entries(nodes, values, slopes, weights, tables, lines, owners, axes, frames, lam, mu):
    """Products of the added functions with those of the nodes and with one another.

    Parameters
    ----------
    nodes : (a, 3), m, of the element
    values, slopes, weights : (q, a), (q, a, 3) and (q,) of the nodes' functions, by the reference coordinates
    tables : (f, q, 9), an added function across the edge and its derivatives by xi and eta, three components each
    lines : (p, 2, q), the function of a node along the edge and its derivative
    owners : int (f,), the node of every added function
    axes, frames : (p, 3, 3) of the nodes, columns: directions of xi, eta, s in the element, of components in space
    lam, mu : Lame constants, Pa

    Returns
    -------
    stiffness with the nodes (a, 3, f) and among themselves (f, f), mass of unit density alike
    """
    f_count, q_count, a_count = len(owners), len(weights), len(nodes)
    K_nodes, K_own = np.zeros((a_count, 3, f_count)), np.zeros((f_count, f_count))
    M_nodes, M_own = np.zeros((a_count, 3, f_count)), np.zeros((f_count, f_count))
    v, g, s = np.empty((3, f_count)), np.empty((9, f_count)), np.empty((9, f_count))
    J, inverse, turned, local = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    for q in range(q_count):
        J[:] = 0.0  # derivatives of the places by the reference coordinates, rows by place
        for a in range(a_count):
            for d in range(3):
                for r in range(3):
                    J[d, r] += nodes[a, d] * slopes[q, a, r]
        for d in range(3):
            e, h = (d + 1) % 3, (d + 2) % 3
            for r in range(3):
                t, u = (r + 1) % 3, (r + 2) % 3
                inverse[r, d] = J[e, t] * J[h, u] - J[e, u] * J[h, t]
        determinant = J[0, 0] * inverse[0, 0] + J[0, 1] * inverse[1, 0] + J[0, 2] * inverse[2, 0]
        inverse /= determinant
        w, part = determinant * weights[q], -1
        for f in range(f_count):
            if owners[f] != part:
                part = owners[f]
                n, slope = lines[part, 0, q], lines[part, 1, q]
                for k in range(3):  # directions of xi, eta, s in space
                    for d in range(3):
                        turned[k, d] = 0.0
                        for r in range(3):
                            turned[k, d] += axes[part, r, k] * inverse[r, d]
            for c in range(3):
                for k in range(3):
                    local[k] = 0.0
                    for b in range(3):
                        local[k] += frames[part, c, b] * tables[f, q, 3 * k + b]
                v[c, f] = n * local[0]
                for d in range(3):
                    g[3 * c + d, f] = n * (turned[0, d] * local[1] + turned[1, d] * local[2])
                    g[3 * c + d, f] += slope * turned[2, d] * local[0]
        for f in range(f_count):
            pressure = lam * (g[0, f] + g[4, f] + g[8, f])
            for c in range(3):
                for d in range(3):
                    s[3 * c + d, f] = w * mu * (g[3 * c + d, f] + g[3 * d + c, f])
                s[4 * c, f] += w * pressure
        for a in range(a_count):
            share = w * values[q, a]
            for d in range(3):
                local[d] = 0.0
                for r in range(3):
                    local[d] += slopes[q, a, r] * inverse[r, d]
            x, y, z = local
            for c in range(3):
                for f in range(f_count):
                    K_nodes[a, c, f] += x * s[3 * c, f] + y * s[3 * c + 1, f] + z * s[3 * c + 2, f]
                    M_nodes[a, c, f] += share * v[c, f]
        for f in range(f_count):
            for k in range(9):
                strain = g[k, f]
                for h in range(f_count):
                    K_own[f, h] += strain * s[k, h]
            for c in range(3):
                moved = w * v[c, f]
                for h in range(f_count):
                    M_own[f, h] += moved * v[c, h]
    return K_nodes, K_own, M_nodes, M_own
