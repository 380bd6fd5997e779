"""Cylinder or plane that fits the triangles of one face; bores are found in `fem.casing.recognition.bores_and_faces`.

The first estimate of the axis is the direction perpendicular to the normals (the eigenvector of sum a n n^T with the
least eigenvalue); that of the circle follows from Kasa's linear least squares. Both are then refined on the corners,
which are on the cylinder even for coarse triangles.

Reference: Shakarji (1998), J. Res. NIST 103(6), 633-641 (least squares cylinder).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.numerics.fitted_circle import kasa_circle

_PERPENDICULAR = 0.01  # largest mean square cosine between the normals and the axis
_ROUND = 0.004  # of the radius, largest deviation of a corner
_LEAST_TURN = 0.003  # least second eigenvalue: about 20 degrees of a cylinder
_ENOUGH = 400  # corners in the fit of five unknowns; the result is checked at all corners
_FLAT = math.cos(math.radians(0.5))


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder (m) with its corners; `hole` if the material is outside."""

    axis: np.ndarray  # (3,)
    point: np.ndarray  # (3,), a point of the axis
    radius: float
    hole: bool
    corners: np.ndarray  # (k, 3)


def fitted_cylinder(points: np.ndarray, triangles: np.ndarray, area_vectors: np.ndarray) -> Cylinder | None:
    """The cylinder through triangles (t, 3) of points (n, 3) m with outward area vectors (t, 3) m2, or None."""
    area = np.linalg.norm(area_vectors, axis=1)
    normals = area_vectors / np.maximum(area, 1e-300)[:, None]
    share = np.einsum("t,ti,tj->ij", area / area.sum(), normals, normals)
    values, vectors = np.linalg.eigh(share)
    if values[0] > _PERPENDICULAR or values[1] < _LEAST_TURN:
        return None
    middles = points[triangles].mean(axis=1)
    points = points[np.unique(triangles)]
    if len(points) < 5:
        return None
    refined = _refined(points[:: -(-len(points) // _ENOUGH)], vectors[:, 0])
    if refined is None:
        return None
    axis, point, radius = refined
    radial = points - point - np.outer((points - point) @ axis, axis)
    if abs(np.linalg.norm(radial, axis=1) - radius).max() > _ROUND * radius:
        return None
    middle = middles - point
    middle = middle - np.outer(middle @ axis, axis)
    hole = float((area_vectors * middle).sum()) < 0.0
    return Cylinder(axis, point, radius, hole, points)


def _refined(points: np.ndarray, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Axis, a point of it, and radius of the least-squares cylinder, from a first direction."""
    from scipy.optimize import least_squares

    origin, size = points.mean(axis=0), float(np.ptp(points, axis=0).max())
    if size <= 0.0:
        return None
    local = (points - origin) / size
    across = np.linalg.svd(axis[None])[2][1:]
    centre, square, _ = kasa_circle(local @ across.T)
    if not 0.0 < square < 1e6:
        return None

    def off(unknowns: np.ndarray) -> np.ndarray:
        direction = axis + unknowns[:2] @ across
        direction = direction / np.linalg.norm(direction)
        offset = local - unknowns[2:4] @ across
        return np.linalg.norm(offset - np.outer(offset @ direction, direction), axis=1) - unknowns[4]

    found = least_squares(off, [0.0, 0.0, *centre, math.sqrt(square)], method="trf", xtol=1e-14, ftol=1e-14, gtol=1e-14)
    tilt, place, radius = found.x[:2], found.x[2:4], float(found.x[4])
    direction = axis + tilt @ across
    direction = direction / np.linalg.norm(direction)
    return direction, origin + size * (place @ across), abs(radius) * size


def is_flat(area_vectors: np.ndarray) -> bool:
    """Whether the triangles of a face with area vectors (t, 3) have one normal."""
    area = np.linalg.norm(area_vectors, axis=1)
    normal = area_vectors.sum(axis=0)
    size = np.linalg.norm(normal)
    real = area > 1e-6 * area.max()
    return bool(size > 0.0 and (area_vectors[real] @ normal > _FLAT * size * area[real]).all())


def turn(cylinder_points: np.ndarray, point: np.ndarray, axis: np.ndarray) -> float:
    """Angle (rad) that points (k, 3) cover around an axis, up to a full turn."""
    across = np.linalg.svd(axis[None])[2][1:]
    x, y = ((cylinder_points - point) @ across.T).T
    angles = np.sort(np.unique(np.arctan2(y, x).round(6)))
    gaps = np.diff(np.append(angles, angles[0] + 2 * math.pi))
    empty = gaps > max(1.5 * float(np.median(gaps)), math.radians(50.0))
    return 2 * math.pi - float(gaps[empty].sum())
