"""Faces of a surface of triangles, found by the angles at its edges; a CAD file gives its faces itself.

Coplanar triangles form flat faces if they are wider than an element. The others form the curved faces, connected over
edges of less than 40 degrees.
"""

from __future__ import annotations

import numpy as np

from fem.casing.mesh.surface import Surface
from fem.numerics.connected_parts import connected_parts, shared_sides

_PLANE = np.cos(np.radians(0.5))
_SMOOTH = np.cos(np.radians(40.0))
_REACH = 2.5  # mean edges: coplanar triangles of this width form a flat face
_SHARP_BORDER = 0.5  # of its boundary: a narrower set is a flat face if this share is sharp


def split(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Number (t,) of the face of every triangle of a closed surface: points (n, 3), triangles (t, 3)."""
    surface = Surface(points, triangles)
    corners, normals = surface.corners, surface.normals
    sides, others = shared_sides(triangles)
    one, two = sides // 3, others // 3
    length = np.linalg.norm(corners[one, sides % 3] - corners[one, (sides + 1) % 3], axis=1)
    cosine = np.einsum("kd,kd->k", normals[one], normals[two])
    even = cosine > _PLANE
    coplanar = connected_parts(len(triangles), one[even], two[even])
    area = np.linalg.norm(surface.area_vectors, axis=1)
    flat = _flat_parts(area, coplanar, one, two, length, cosine)
    is_flat = flat[coplanar]
    joined = (cosine > _SMOOTH) & ~is_flat[one] & ~is_flat[two] | (coplanar[one] == coplanar[two])
    return connected_parts(len(triangles), one[joined], two[joined])


def _flat_parts(
    area: np.ndarray,
    part: np.ndarray,
    one: np.ndarray,
    two: np.ndarray,
    length: np.ndarray,
    cosine: np.ndarray,
) -> np.ndarray:
    """Bool (part,): whether coplanar triangles are a flat face, not a strip of a curved one."""
    count = part.max() + 1
    border = part[one] != part[two]
    sharp = border & (cosine < _SMOOTH)
    around, cut = np.zeros(count), np.zeros(count)
    for side in (one, two):
        np.add.at(around, part[side[border]], length[border])
        np.add.at(cut, part[side[sharp]], length[sharp])
    total = np.bincount(part, weights=area, minlength=count)
    width = 2.0 * total / np.maximum(around, 1e-300)  # of a long strip
    edge = float(np.median(length))
    return (width > _REACH * edge) | (cut > _SHARP_BORDER * around) & (np.bincount(part, minlength=count) > 1)
