"""Modes of one body on different meshes, paired by their shapes.

    MAC(a, b) = (phi_a . phi_b)^2 / ((phi_a . phi_a)(phi_b . phi_b))

over displacements at the same positions of both meshes. The pairs are those with the largest sum of MAC, so that modes
are paired even if their order differs between meshes. Close modes that mix may remain without a counterpart.

Reference: Allemang (2003), The modal assurance criterion - twenty years of use and abuse, Sound and Vibration 37(8).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

LEAST_MAC = 0.5  # of a pair: below it the two modes may differ
_ALONG = 6  # grid points along each side of the box


def sample_nodes(nodes: np.ndarray) -> np.ndarray:
    """Numbers (s,) of the nodes (n, 3) nearest to a grid in the box around a body: the same positions on every mesh.

    They deviate by up to half the distance of two nodes, a twentieth of the wavelength of the highest modes compared.
    """
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    share = np.linspace(0.0, 1.0, _ALONG)
    grid = np.stack(np.meshgrid(share, share, share, indexing="ij"), axis=-1).reshape(-1, 3)
    return np.asarray(cKDTree(nodes).query(low + (high - low) * grid)[1])


def assurance(shapes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """MAC (m, n) of all pairs of modes; parameters as those of `counterparts`."""
    product = (shapes.T @ others) ** 2
    return np.asarray(product / np.outer((shapes**2).sum(axis=0), (others**2).sum(axis=0)))


def counterparts(shapes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Number (m,) of the counterpart of every mode among the others, -1 if there is none.

    Parameters
    ----------
    shapes : (k, m), displacements of the modes at k unknowns
    others : (k, n), of the modes of another mesh at the same positions
    """
    mac = assurance(shapes, others)
    found = np.full(shapes.shape[1], -1)
    one, other = linear_sum_assignment(mac, maximize=True)
    alike = mac[one, other] >= LEAST_MAC
    found[one[alike]] = other[alike]
    return found
