"""Triangles to look at: as many as a page can bear, small ones between merged points left out.

Points are merged in the cells of a grid, the finest of a ladder that leaves few enough triangles with three different
points. Nothing is computed with them.

Reference: Rossignac & Borrel (1993), Multi-resolution 3D approximations for rendering complex scenes.
"""

from __future__ import annotations

import numpy as np

MOST_TRIANGLES = 125_000  # 3 MB of a page
_CELLS = 2000  # of the finest grid along the longest side


def thinned(points: np.ndarray, triangles: np.ndarray, most: int = MOST_TRIANGLES) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles, `most` of them at most.

    Parameters
    ----------
    points : (n, 3)
    triangles : int (t, 3), into the points
    most : triangles
    """
    cells = _CELLS
    low, side = points.min(axis=0), float(np.ptp(points, axis=0).max())
    found = points, triangles
    while len(found[1]) > most:
        cell = np.floor((points - low) / side * cells).astype(np.int64)
        _, first, number = np.unique(cell, axis=0, return_index=True, return_inverse=True)
        merged = number.ravel()[triangles]
        whole = merged[(merged != np.roll(merged, 1, axis=1)).all(axis=1)]
        once = np.unique(np.sort(whole, axis=1), axis=0, return_index=True)[1]
        found = points[first], whole[np.sort(once)]
        cells = 3 * cells // 4
    return found
