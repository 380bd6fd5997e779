"""Find a key point of an imported housing on its surface by name, cylinder, point, box or plane.

All searches use the corner triangles of the outer surface, for housings from any source. If nothing is found, the error
lists the nearest candidates.
"""

from __future__ import annotations

import numpy as np

from fem.casing.geometry.locators import ByBox, ByCylinder, ByGroup, ByPlane, ByPoint, Locator, Point
from fem.casing.mesh.candidate_texts import cylinders_like, planes_like
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.surface import Surface
from fem.elements.facets import nearest_in_triangles
from fem.numerics.message_places import in_mm

RADIUS_TOLERANCE = 0.005  # of the radius: largest distance of a corner from the target cylinder
PLANE_TOLERANCE = 5e-5  # m: largest distance of a corner from the plane
FARTHEST_POINT = 0.005  # m: largest distance of a given point from the surface
_FLAT = np.cos(np.radians(1.0))  # largest angle between facets of one plane
_FACING = 0.8  # least cosine between the normal of a facet and the radius of its cylinder


def locate(surface: Surface, name: str, locator: Locator) -> np.ndarray:
    """Indices of the facets of one key point.

    Raises
    ------
    MeshError : nothing found; the message gives the nearest candidates
    """
    match locator:
        case ByGroup():
            return _group(surface, name, locator)
        case ByCylinder():
            return _cylinder(surface, name, locator)
        case ByPoint():
            return _face(surface, name, locator)
        case ByBox():
            low, high = locator.box
            inside = (surface.corners >= low).all(axis=(1, 2)) & (surface.corners <= high).all(axis=(1, 2))
            if not inside.any():
                raise MeshError(
                    f"{name}: no surface lies inside the box {in_mm(low)} to {in_mm(high)}; {_span(surface)}"
                )
            return np.flatnonzero(inside)
        case ByPlane():
            return np.concatenate(plane_parts(surface, name, locator))


def plane_parts(surface: Surface, name: str, locator: ByPlane) -> list[np.ndarray]:
    """The unconnected parts of a plane, sorted by x, then y, then z of their centroids (to 1 mm)."""
    normal = _unit(locator.normal)
    along = np.abs(surface.normals @ normal) > _FLAT
    off = np.abs((surface.corners - np.array(locator.through)) @ normal).max(axis=1)
    parts = surface.parts(along & (off < PLANE_TOLERANCE))
    if not parts:
        raise MeshError(
            f"{name}: no flat face in the plane through {in_mm(locator.through)} with the normal {locator.normal}; "
            f"{planes_like(surface, normal, np.array(locator.through))}"
        )
    return sorted(parts, key=lambda part: tuple(np.round(centroid(surface, part), 3)))


def axis_place(surface: Surface, facets: np.ndarray, through: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """The point (3,) of an axis in the middle of the extent of the facets along it.

    Parameters
    ----------
    surface : of the housing
    facets : int (f,), indices into its triangles
    through : (3,) m, a point of the axis
    axis : (3,), its direction, of any length
    """
    axis = _unit(axis)
    along = (surface.corners[facets] - through) @ axis
    return np.asarray(through, float) + axis * 0.5 * float(along.min() + along.max())


def centroid(surface: Surface, facets: np.ndarray) -> np.ndarray:
    """Area centroid (3,) of facets."""
    weights = np.linalg.norm(surface.area_vectors[facets], axis=1)
    return np.average(surface.corners[facets].mean(axis=1), axis=0, weights=weights)


def _group(surface: Surface, name: str, locator: ByGroup) -> np.ndarray:
    if locator.group not in surface.groups:
        known = ", ".join(surface.groups) or "none (a STEP file has no groups; locate by cylinder, point or plane)"
        raise MeshError(f"{name}: the file has no group {locator.group!r}; it has: {known}")
    facets = np.flatnonzero(surface.groups[locator.group])
    if not len(facets):
        raise MeshError(
            f"{name}: the group {locator.group!r} holds no facet of the outer surface; name a surface group"
        )
    return facets


def _cylinder(surface: Surface, name: str, locator: ByCylinder) -> np.ndarray:
    axis, through, radius = _unit(locator.axis), np.array(locator.through), locator.diameter / 2
    offset = surface.corners - through
    radial = offset - (offset @ axis)[..., None] * axis
    on = np.abs(np.linalg.norm(radial, axis=2) - radius).max(axis=1) < RADIUS_TOLERANCE * radius
    vectors, middle = surface.area_vectors, radial.mean(axis=1)
    size = np.linalg.norm(vectors, axis=1) * np.linalg.norm(middle, axis=1)
    facing = np.abs(np.einsum("fd,fd->f", vectors, middle)) > _FACING * size
    parts = surface.parts(on & facing)
    if not parts:
        raise MeshError(
            f"{name}: no cylinder of diameter {1000 * locator.diameter:.6g} mm about the axis {locator.axis} through "
            f"{in_mm(through)}; {cylinders_like(surface, axis, through)}. Correct "
            "through_mm, diameter_mm, axis, or axes and unit of the file"
        )
    along = [offset[part] @ axis for part in parts]
    return parts[int(np.argmin([max(a.min(), -a.max(), 0.0) for a in along]))]


def _face(surface: Surface, name: str, locator: ByPoint) -> np.ndarray:
    point, corners = np.array(locator.point), surface.corners
    distance = nearest_in_triangles(corners, point)[1]
    nearest = int(distance.argmin())
    if distance[nearest] > FARTHEST_POINT:
        raise MeshError(
            f"{name}: the point {in_mm(point)} is {1000 * distance[nearest]:.4g} mm from the surface (limit "
            f"{1000 * FARTHEST_POINT:g} mm); the nearest facet is at {in_mm(corners[nearest].mean(axis=0))}"
        )
    vectors = surface.area_vectors
    normal = _unit(vectors[nearest])
    same = vectors @ normal > _FLAT * np.linalg.norm(vectors, axis=1)
    flat = same & (np.abs((corners - corners[nearest, 0]) @ normal).max(axis=1) < PLANE_TOLERANCE)
    return next(part for part in surface.parts(flat) if nearest in part)


def _unit(vector: Point | np.ndarray) -> np.ndarray:
    vector = np.asarray(vector, float)
    if not (size := float(np.linalg.norm(vector))) > 0.0:
        raise MeshError(f"the direction {tuple(vector)} has no length; give a vector such as (0, 1, 0)")
    return vector / size


def _span(surface: Surface) -> str:
    low, high = surface.points[surface.triangles].min(axis=(0, 1)), surface.points[surface.triangles].max(axis=(0, 1))
    return f"the surface spans {in_mm(low)} to {in_mm(high)}"
