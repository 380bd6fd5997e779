"""Grids of quadratic cells: lines with the middles of their cells, and the nodes of the cells of a plane grid."""

from __future__ import annotations

import numpy as np


def with_middles(ends: np.ndarray) -> np.ndarray:
    """Cell ends (n,) with the cell middles between them (2 n - 1,)."""
    out = np.empty(2 * len(ends) - 1)
    out[::2], out[1::2] = ends, 0.5 * (ends[1:] + ends[:-1])
    return out


def cells_of(nodes: np.ndarray) -> np.ndarray:
    """Nodes (c, 3, 3) of the cells of a grid of nodes with odd counts, which includes the middles."""
    return np.lib.stride_tricks.sliding_window_view(nodes, (3, 3))[::2, ::2].reshape(-1, 3, 3)
