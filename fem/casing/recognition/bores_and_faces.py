"""Bores, flat faces and bolt patterns of a surface whose faces are known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, groupby, pairwise

import numpy as np

from fem.casing.mesh.surface import Surface
from fem.casing.recognition.cylinders import Cylinder, fitted_cylinder, is_flat, turn
from fem.casing.recognition.housing_contents import BoltPattern, FlatFace, FoundBore
from fem.numerics.connected_parts import connected_parts
from fem.numerics.fitted_circle import fitted_circle

_SAME_AXIS = 2e-5  # m, and
_SAME_RADIUS = 1e-3  # of the radius: tolerances within which cylinders are one bore
_PARALLEL = math.cos(math.radians(0.2))
_LEAST_ANGLE = math.radians(170.0)  # of a bore: includes one half of a split bore, excludes fillets
_LEVEL = 2e-4  # m: tolerance of the plane in which holes of a pattern begin
_ON_CIRCLE = 1e-4  # m


def faces_of(
    points: np.ndarray, triangles: np.ndarray, face: np.ndarray, solid: np.ndarray
) -> tuple[tuple[FoundBore, ...], tuple[FlatFace, ...]]:
    """Bores, the widest first, and flat faces, the largest first.

    Parameters
    ----------
    points, triangles : of the surface, (n, 3) m and (t, 3), seen from outside counter-clockwise
    face, solid : int (t,), number of the face and of the solid of every triangle
    """
    surface = Surface(points, triangles)
    corners, vectors = surface.corners, surface.area_vectors
    order = np.argsort(face, kind="stable")
    cylinders: list[tuple[Cylinder, int]] = []
    flats: list[FlatFace] = []
    for members in np.split(order, np.flatnonzero(np.diff(face[order])) + 1):
        if is_flat(vectors[members]):
            flats.append(_flat(corners[members], vectors[members], int(solid[members[0]])))
        elif (found := fitted_cylinder(points, triangles[members], vectors[members])) is not None and found.hole:
            cylinders.append((found, int(solid[members[0]])))
    flats.sort(key=lambda one: -one.area)
    named = tuple(replace(flat, number=number) for number, flat in enumerate(flats, 1))
    return tuple(_bores(cylinders)), named


def _flat(corners: np.ndarray, vectors: np.ndarray, solid: int) -> FlatFace:
    area = np.linalg.norm(vectors, axis=1)
    total = vectors.sum(axis=0)
    centre = np.average(corners.mean(axis=1), axis=0, weights=area)
    return FlatFace(number=0, solid=solid, area=float(area.sum()), centre=centre, normal=total / np.linalg.norm(total))


def _bores(cylinders: Sequence[tuple[Cylinder, int]]) -> list[FoundBore]:
    """Merge cylindrical faces of one axis and radius that touch along it."""
    several = combinations(enumerate(cylinders), 2)
    pairs = np.array([(i, j) for (i, (one, _)), (j, (two, _)) in several if _same(one, two)], int).reshape(-1, 2)
    label, found = connected_parts(len(cylinders), pairs[:, 0], pairs[:, 1]), []
    for part in np.unique(label):
        own = [cylinders[i] for i in np.flatnonzero(label == part).tolist()]
        first, solid = own[0]
        corners = np.vstack([one.corners for one, _ in own])
        low, high = _span(corners, first)
        angle = turn(corners, first.point, first.axis)
        if angle >= _LEAST_ANGLE:
            sign = math.copysign(1.0, first.axis[np.abs(first.axis).argmax()])
            centre = first.point + 0.5 * (low + high) * first.axis
            found.append((first.radius, solid, sign * first.axis, centre, high - low, angle))
    found.sort(key=lambda one: (-round(one[0], 6), *np.round(one[3], 6)))
    return [
        FoundBore(number=n, solid=solid, axis=axis, centre=centre, diameter=2 * radius, length=length, angle=angle)
        for n, (radius, solid, axis, centre, length, angle) in enumerate(found, 1)
    ]


def _span(corners: np.ndarray, along: Cylinder) -> tuple[float, float]:
    places = (corners - along.point) @ along.axis
    return float(places.min()), float(places.max())


def _same(one: Cylinder, two: Cylinder) -> bool:
    """Whether two faces have one axis and one radius, and touch along the axis."""
    if abs(one.axis @ two.axis) < _PARALLEL or abs(one.radius - two.radius) > _SAME_RADIUS * one.radius:
        return False
    middle = two.corners.mean(axis=0)
    on_two = two.point + two.axis * ((middle - two.point) @ two.axis)
    offset = on_two - one.point
    if np.linalg.norm(offset - one.axis * (offset @ one.axis)) >= max(_SAME_AXIS, 2e-3 * one.radius):
        return False
    (low, high), (start, end) = _span(one.corners, one), _span(two.corners, one)
    return start < high + _SAME_AXIS and end > low - _SAME_AXIS


def bolt_patterns(bores: Sequence[FoundBore]) -> tuple[BoltPattern, ...]:
    """Groups of three or more equal parallel holes that begin in one plane, with their circles.

    Circles about a wider parallel bore are tried first, then one circle through the remaining holes of a group.
    """

    def kind(bore: FoundBore) -> tuple:
        return tuple(np.round(bore.axis, 3)), round(bore.diameter, 5), round(bore.length, 4)

    def level(bore: FoundBore) -> float:
        return float(bore.centre @ bore.axis)

    patterns = []
    for _, group in groupby(sorted(bores, key=kind), key=kind):
        holes = sorted(group, key=level)
        starts = [i for i in range(1, len(holes)) if level(holes[i]) - level(holes[i - 1]) > _LEVEL]
        for start, end in pairwise((0, *starts, len(holes))):
            patterns += _circles(holes[start:end], bores)
    return tuple(sorted(patterns, key=lambda one: one.bores))


def _circles(holes: list[FoundBore], bores: Sequence[FoundBore]) -> list[BoltPattern]:
    found, left = [], list(holes)
    if len(left) < 3:
        return []
    axis = left[0].axis
    across = np.linalg.svd(axis[None])[2][1:]
    for wide in bores:
        if wide.diameter < 1.5 * holes[0].diameter or abs(wide.axis @ axis) < _PARALLEL:
            continue
        middle = wide.centre @ across.T
        distance = {one.number: float(np.linalg.norm(one.centre @ across.T - middle)) for one in left}
        for radius in sorted(set(np.round(list(distance.values()), 4))):
            on = [one for one in left if abs(distance[one.number] - radius) < _ON_CIRCLE]
            if len(on) >= 3 and _around(np.array([one.centre for one in on]) @ across.T - middle):
                found.append(_pattern(on, 2 * float(np.mean([distance[one.number] for one in on])), wide))
                left = [one for one in left if one not in on]
    if len(left) >= 3:
        places = np.array([one.centre for one in left]) @ across.T
        circle = fitted_circle(places)
        if circle is not None and len(left) > 3 and _on(places, *circle):
            found.append(_pattern(left, 2 * circle[1], None, circle[0] @ across + axis * (left[0].centre @ axis)))
        else:
            found.append(_pattern(left, 0.0, None))
    return found


def _on(places: np.ndarray, middle: np.ndarray, radius: float) -> bool:
    """Whether points (k, 2) are on a circle and surround its centre; a straight row of holes is not a circle."""
    return abs(np.linalg.norm(places - middle, axis=1) - radius).max() < _ON_CIRCLE and _around(places - middle)


def _around(offsets: np.ndarray) -> bool:
    """Whether points (k, 2) surround the origin: no gap of more than 200 degrees."""
    angles = np.sort(np.arctan2(offsets[:, 1], offsets[:, 0]))
    return bool(np.diff(np.append(angles, angles[0] + 2 * math.pi)).max() < math.radians(200.0))


def _pattern(
    holes: Sequence[FoundBore], circle: float, wide: FoundBore | None, centre: np.ndarray | None = None
) -> BoltPattern:
    if centre is None:
        middle = np.mean([one.centre for one in holes], axis=0)
        centre = middle if wide is None else wide.centre + wide.axis * ((middle - wide.centre) @ wide.axis)
    return BoltPattern(
        bores=tuple(sorted(one.number for one in holes)),
        hole_diameter=holes[0].diameter,
        circle_diameter=circle,
        centre=centre,
        around=0 if wide is None else wide.number,
    )
