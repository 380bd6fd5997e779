"""Transformation of a gear pair from the axes of its picture to the global axes.

In a picture's frame the pinion's axis is z along its rotation in lifting, and the wheel lies at +x. Globally y runs
along the shafts and z is up, so that gears lie over the casing.
"""

from __future__ import annotations

import numpy as np


def scene_frame(pinion: tuple[float, float], wheel: tuple[float, float], y: float, sense: int) -> np.ndarray:
    """The matrix (4, 4) that takes points of the picture's frame to the scene, m.

    Parameters
    ----------
    pinion, wheel : axes (x, z) of the shafts, m
    y : mid face of the gears, m
    sense : +1 where the pinion turns about +y in lifting, else -1
    """
    across = np.array([wheel[0] - pinion[0], 0.0, wheel[1] - pinion[1]])
    across /= np.linalg.norm(across)
    along = np.array([0.0, float(sense), 0.0])
    frame = np.eye(4)
    frame[:3, :3] = np.column_stack([across, np.cross(along, across), along])
    frame[:3, 3] = [pinion[0], y, pinion[1]]
    return frame


def placed(points: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """Points (..., 3) in the scene."""
    return np.asarray(points @ frame[:3, :3].T + frame[:3, 3])


def rotated(vectors: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) of the picture's frame in the scene."""
    return np.asarray(vectors @ frame[:3, :3].T)
