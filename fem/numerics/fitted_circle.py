"""The circle through points of a plane, fitted by Kasa's linear least squares."""

from __future__ import annotations

import numpy as np


def kasa_circle(points: np.ndarray) -> tuple[np.ndarray, float, int]:
    """Centre (2,), squared radius and rank of the least-squares problem (2 on a straight line) for points (n, 2)."""
    system = np.column_stack([points, np.ones(len(points))])
    solution, _, rank, _ = np.linalg.lstsq(system, (points**2).sum(axis=1), rcond=None)
    return solution[:2] / 2, float(solution[2] + (solution[:2] ** 2).sum() / 4), int(rank)


def fitted_circle(points: np.ndarray) -> tuple[np.ndarray, float] | None:
    """Centre (2,) and radius of the circle through points (n, 2); None if one deviates by more than 2 %, or if they are
    on a straight line."""
    centre, square, rank = kasa_circle(points)
    if rank < 3 or square <= 0.0:
        return None
    radius = float(np.sqrt(square))
    off = np.abs(np.linalg.norm(points - centre, axis=1) - radius).max()
    return (centre, radius) if off <= 0.02 * radius else None
