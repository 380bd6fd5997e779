"""Modes of one body on different meshes, paired by their shapes.

    MAC(a, b) = (phi_a . phi_b)^2 / ((phi_a . phi_a)(phi_b . phi_b))

over displacements at the same places of both meshes. The pairs are those with the largest sum of MAC, so that modes
which change their order from mesh to mesh find their counterparts; close modes that mix may not, and stay alone.

Reference: Allemang (2003), The modal assurance criterion - twenty years of use and abuse, Sound and Vibration 37(8).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

LEAST_MAC = 0.5  # of a pair: two modes that share less may be two different ones
_ALONG = 6  # places along each side of the box


def sample_nodes(nodes: np.ndarray) -> np.ndarray:
    """Numbers (s,) of the nodes (n, 3) nearest to a grid in the box around a body: on every mesh of it the same places.

    Off by half the distance of two nodes, a twentieth of the wave of the highest modes that are looked at.
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
    """For every mode (m,) the number of its counterpart among the others, -1 where there is none.

    Parameters
    ----------
    shapes : (k, m), displacements of the modes at k unknowns
    others : (k, n), of the modes of another mesh at the same places
    """
    mac = assurance(shapes, others)
    found = np.full(shapes.shape[1], -1)
    one, other = linear_sum_assignment(mac, maximize=True)
    alike = mac[one, other] >= LEAST_MAC
    found[one[alike]] = other[alike]
    return found
