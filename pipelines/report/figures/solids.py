"""Surfaces of gears and teeth for pictures: a transverse outline, swept along the helix."""

from __future__ import annotations

import numpy as np


def without_tooth(outline: np.ndarray, teeth: int, centre_angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Remove one tooth from an outline.

    Parameters
    ----------
    outline : float (n, 2), m, counter-clockwise, gear centre at the origin
    centre_angle : rad, polar angle of the middle of the tooth

    Returns
    -------
    outline with the root circle in place of the tooth, and the outline of the removed tooth, float (k, 2)
    """
    radius, angle = np.hypot(*outline.T), np.arctan2(outline[:, 1], outline[:, 0])
    offset = (angle - centre_angle + np.pi) % (2 * np.pi) - np.pi
    half = np.pi / teeth
    inside = np.abs(offset) < half * (1 - 1e-6)  # the middles of the two spaces are kept
    root = radius[inside].min()
    first = np.flatnonzero(~inside & np.roll(inside, -1))[0] + 1  # start of the tooth, counter-clockwise
    rolled, gone = np.roll(outline, -first, axis=0), np.roll(inside, -first)
    tooth, rest = rolled[gone], rolled[~gone]
    sweep = centre_angle + np.linspace(-half, half, 11)[1:-1]
    arc = root * np.column_stack([np.cos(sweep), np.sin(sweep)])
    return np.vstack([rest, arc]), tooth


def gear_surface(
    outline: np.ndarray,
    bore: float,
    twist: float,
    face_width: float,
    layers: int = 13,
    web: tuple[float, float, float] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Closed surface of a gear: outline and bore swept along the helix, rings of quadrilaterals between them.

    Parameters
    ----------
    outline : float (n, 2), m, transverse section at mid face, counter-clockwise
    bore : radius, m
    twist : rad per m of face width, positive for a rotation about +z with growing z
    face_width : m
    layers : sections along the face, including the end faces
    web : inner radius of the rim and ends of the web along the face, m; None: a solid body

    Returns
    -------
    points : float (p, 3), m, axis along z, mid face at z = 0
    quads : int (q, 4), normals outwards
    """
    count, half = len(outline), face_width / 2
    angle = np.arctan2(outline[:, 1], outline[:, 0])
    corners = [(bore, -half), (bore, half)]  # (radius, face) of the body's section, from one end face to the other
    if web is not None:
        rim, low, high = web
        corners = [(rim, -half), (rim, low), (bore, low), (bore, high), (rim, high), (rim, half)]
    rings = [_ring(radius, angle, twist, face) for radius, face in corners]
    points = np.concatenate([_drawn(outline, twist, face_width, layers), *rings])
    first, last = count * layers, count * (layers + len(corners) - 1)
    inside = _walls(count, len(corners))[:, ::-1] + first
    here = np.arange(count)
    after = np.roll(here, -1)
    top = count * (layers - 1)
    bottom_face = np.column_stack([here, here + first, after + first, after])
    top_face = np.column_stack([here + top, after + top, after + last, here + last])
    return points, np.concatenate([_walls(count, layers), inside, bottom_face, top_face])


def _ring(radius: float, angle: np.ndarray, twist: float, face: float) -> np.ndarray:
    turned = angle + twist * face
    return np.column_stack([radius * np.cos(turned), radius * np.sin(turned), np.full(angle.size, face)])


def prism_surface(
    outline: np.ndarray, twist: float, face_width: float, layers: int = 13
) -> tuple[np.ndarray, np.ndarray]:
    """Closed surface of a small outline, e.g. one tooth: walls and end faces as fans.

    The fans (quads with a double node) start in the middle between the first and the last point.

    Parameters
    ----------
    outline, twist, face_width, layers : those of `gear_surface`
    """
    count = len(outline)
    centre = outline[[0, -1]].mean(axis=0, keepdims=True)  # a fan about the middle of the base covers a tooth
    points = np.concatenate(
        [_drawn(outline, twist, face_width, layers), _drawn(centre, twist, face_width, layers)[[0, -1]]]
    )
    here = np.arange(count)
    after = np.roll(here, -1)
    low, high = np.full(count, count * layers), np.full(count, count * layers + 1)
    top = count * (layers - 1)
    bottom_face = np.column_stack([low, low, after, here])
    top_face = np.column_stack([high, high, here + top, after + top])
    return points, np.concatenate([_walls(count, layers), bottom_face, top_face])


def _drawn(ring: np.ndarray, twist: float, face_width: float, layers: int) -> np.ndarray:
    sections = []
    for z in np.linspace(-face_width / 2, face_width / 2, layers):
        cosine, sine = np.cos(twist * z), np.sin(twist * z)
        turned = ring @ np.array([[cosine, sine], [-sine, cosine]])
        sections.append(np.column_stack([turned, np.full(len(ring), z)]))
    return np.concatenate(sections)


def _walls(count: int, layers: int) -> np.ndarray:
    here = np.arange(count)
    after = np.roll(here, -1)
    one = np.column_stack([here, after, after + count, here + count])
    return np.concatenate([one + count * layer for layer in range(layers - 1)])
