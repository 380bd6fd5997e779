"""Texts for messages about a key point that was not found: the nearest cylinders and flat faces of a surface.

Cylinders are searched among the facets whose normals are perpendicular to the axis, to 12 degrees: on a coarse mesh the
corners of a facet are at several places around the axis and along it. Facets that share an edge of less than 50 degrees
form a piece. A circle is fitted to the corners of each piece.
"""

from __future__ import annotations

import numpy as np

from fem.casing.mesh.surface import Surface
from fem.numerics.fitted_circle import fitted_circle
from fem.numerics.message_places import in_mm

_SMOOTH = np.cos(np.radians(50.0))
_PERPENDICULAR = np.sin(np.radians(12.0))
_SHOWN = 3


def cylinders_like(surface: Surface, axis: np.ndarray, through: np.ndarray) -> str:
    """The cylinders along `axis` nearest to a point, as text; if there is none, those along x, y and z."""
    if found := _cylinders(surface, axis, through):
        return f"the nearest cylinders along it: {found}"
    others = [(name, _cylinders(surface, along, through)) for name, along in zip("xyz", np.eye(3), strict=True)]
    words = [f"along {name}: {found}" for name, found in others if found] or ["nor one along x, y or z"]
    return f"there is no cylinder along this axis, {', '.join(words)}"


def _cylinders(surface: Surface, axis: np.ndarray, through: np.ndarray) -> str:
    across = np.linalg.svd(axis[None])[2][1:]  # two directions perpendicular to the axis
    found = []
    for part in surface.parts(np.abs(surface.normals @ axis) < _PERPENDICULAR, smooth=_SMOOTH):
        corners = surface.corners[part].reshape(-1, 3)
        fitted = fitted_circle(corners @ across.T) if len(part) >= 6 else None
        if fitted is None:
            continue
        centre, radius = fitted
        place = centre @ across + axis * 0.5 * float((corners @ axis).min() + (corners @ axis).max())
        found.append((float(np.linalg.norm(place - through)), radius, place))
    found.sort(key=lambda one: one[0])
    return "; ".join(f"diameter {2000 * radius:.5g} mm at {in_mm(place)}" for _, radius, place in found[:_SHOWN])


def planes_like(surface: Surface, normal: np.ndarray, through: np.ndarray) -> str:
    """The flat faces with this normal nearest to a plane, as text."""
    vectors = surface.area_vectors
    area = np.linalg.norm(vectors, axis=1)
    level = (surface.corners.mean(axis=1) - through) @ normal
    chosen = np.abs(vectors @ normal) > 0.9998 * area
    if not chosen.any():
        return "no flat face has this normal; check the normal"
    levels = np.round(level[chosen], 5)
    offsets = sorted(set(levels.tolist()), key=abs)[:_SHOWN]
    words = [f"{1000 * o:+.5g} mm along the normal ({1e6 * area[chosen][levels == o].sum():.4g} mm2)" for o in offsets]
    return f"the nearest flat faces with this normal lie {'; '.join(words)}"
