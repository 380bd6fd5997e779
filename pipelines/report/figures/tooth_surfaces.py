"""Surfaces of gears and teeth for pictures: a transverse outline, swept along the helix."""

from __future__ import annotations

import math

import numpy as np

from fem.gears.gear import Gear
from fem.gears.profile import half_tooth_profile


def outline(gear: Gear, centre_angle: float) -> np.ndarray:
    """Transverse profile of all teeth, counter-clockwise (n, 2) in m, the middle of one tooth at `centre_angle`."""
    half = half_tooth_profile(gear, n_fillet=6, n_flank=8, n_tip=2)  # mid space at x > 0 to mid tooth on +y
    tooth = np.vstack([half[:-1], half[::-1] * [-1.0, 1.0]])[:-1]  # counter-clockwise, mid space kept once
    angle = centre_angle - math.pi / 2 + 2 * math.pi * np.arange(gear.teeth) / gear.teeth
    rotations = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return (tooth @ np.moveaxis(rotations, 2, 0)).reshape(-1, 2)


def web(gear: Gear) -> tuple[float, float, float] | None:
    """Inner radius of the rim and ends of the web along the face; None for a solid body."""
    if gear.web_ratio >= 1.0:
        return None
    half = gear.web_ratio * gear.face_width / 2
    return gear.rim_inner_radius, gear.web_offset - half, gear.web_offset + half


def twist(gear: Gear) -> float:
    """Rotation of the section per metre along the axis, rad/m: tan(beta) / r, positive for a right hand."""
    return gear.hand_sign * math.tan(abs(gear.helix_angle)) / gear.reference_radius


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
    corners = [(bore, -half), (bore, half)]  # (radius, face) of the body's section, from one end face to the other
    if web is not None:
        rim, low, high = web
        corners = [(rim, -half), (rim, low), (bore, low), (bore, high), (rim, high), (rim, half)]
    rings = [swept(radius * outline / np.hypot(*outline.T)[:, None], twist, face) for radius, face in corners]
    body = swept(np.tile(outline, (layers, 1, 1)), twist, np.linspace(-half, half, layers)[:, None])
    points = np.concatenate([body.reshape(-1, 3), *rings])
    first, last = count * layers, count * (layers + len(corners) - 1)
    inside = walls(len(corners), count)[:, ::-1] + first
    here = np.arange(count)
    after = np.roll(here, -1)
    top = count * (layers - 1)
    bottom_face = np.column_stack([here, here + first, after + first, after])
    top_face = np.column_stack([here + top, after + top, after + last, here + last])
    return points, np.concatenate([walls(layers, count), inside, bottom_face, top_face])


def prism_surface(
    outline: np.ndarray, twist: float, face_width: float, layers: int = 13
) -> tuple[np.ndarray, np.ndarray]:
    """Closed surface of a small outline, e.g. one tooth; see `fanned`.

    Parameters
    ----------
    outline, twist, face_width, layers : those of `gear_surface`
    """
    face = np.linspace(-face_width / 2, face_width / 2, layers)
    return fanned(np.tile(outline, (layers, 1, 1)), twist, face)


def fanned(flat: np.ndarray, twist: float, face: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Closed surface of outlines (station, k, 2) at the face coordinates: the walls, then both end faces as fans.

    The fans (quads with a double node) start in the middle between the first and the last point, which covers a tooth.
    """
    rows, columns = flat.shape[:2]
    ends = swept(np.tile(flat[0, [0, -1]].mean(axis=0), (2, 1)), twist, face[[0, -1]])
    low, high = np.full(columns, rows * columns), np.full(columns, rows * columns + 1)
    here = np.arange(columns)
    after, top = np.roll(here, -1), columns * (rows - 1)
    bottom_face = np.column_stack([low, low, after, here])
    top_face = np.column_stack([high, high, here + top, after + top])
    points = np.concatenate([swept(flat, twist, face[:, None]).reshape(-1, 3), ends])
    return points, np.concatenate([walls(rows, columns), bottom_face, top_face])


def swept(flat: np.ndarray, twist: float, face: np.ndarray | float) -> np.ndarray:
    """Points (..., 3) of points (..., 2) of a section at mid face, moved along the helix to the face coordinates."""
    angle = twist * np.broadcast_to(face, flat.shape[:-1])
    x = np.cos(angle) * flat[..., 0] - np.sin(angle) * flat[..., 1]
    y = np.sin(angle) * flat[..., 0] + np.cos(angle) * flat[..., 1]
    return np.stack([x, y, np.broadcast_to(face, x.shape)], axis=-1)


def walls(rows: int, columns: int) -> np.ndarray:
    """Quads (q, 4) between the closed rings of a grid of points (row, column)."""
    number = np.arange(rows * columns).reshape(rows, columns)
    after = np.roll(number, -1, axis=1)
    return np.stack([number[:-1], after[:-1], after[1:], number[1:]], axis=-1).reshape(-1, 4)
