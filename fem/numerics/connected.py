"""Connected parts of a graph."""

from __future__ import annotations

import numpy as np


def connected_parts(size: int, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Number of the connected part of every vertex.

    Parameters
    ----------
    size : number of vertices
    one, other : int (edge,), the vertices of every edge

    Returns
    -------
    part : int (size,), from 0
    """
    from scipy.sparse import coo_matrix  # late: commands that only read a scene start sooner
    from scipy.sparse.csgraph import connected_components

    graph = coo_matrix((np.ones(len(one)), (one, other)), shape=(size, size))
    return np.asarray(connected_components(graph, directed=False)[1])
