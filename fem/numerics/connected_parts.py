"""Connected parts of a graph, and the triangles of a surface that share an edge."""

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


def shared_sides(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sides (k,) of triangles (t, 3), and the same sides (k,) as those of their neighbours.

    Side s of triangle t has the number 3 t + s and joins the corners s and s + 1.
    """
    sides = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    number = np.unique(sides, axis=0, return_inverse=True)[1].ravel()
    order = np.argsort(number, kind="stable")
    pair = np.flatnonzero(np.diff(number[order]) == 0)
    return order[pair], order[pair + 1]
