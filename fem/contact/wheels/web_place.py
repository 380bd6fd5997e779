"""Position of the web of a gear along its face, and the axial elements that fit it.

A web wider than the face has no elements beyond the face. It is modelled as a ring under the whole face with its
modulus raised by b_s / b. The reduction of rim and web is in `fem.contact.wheels.solid_ring`.
"""

from __future__ import annotations

import math

import numpy as np

from fem.gears.gear import Gear
from fem.gears.geometry import GearPair

_GRADING = 0.16  # elements at the free end faces are half as long as those at mid face
_CLOSE = 1e-9  # of the face width: ends that are the same


def web_ends(gear: Gear, turn: int) -> tuple[float, float] | None:
    """Ends of the web along the axis (m, 0 at mid face); None if body or web fill the face.

    Parameters
    ----------
    gear : with its web_offset along y
    turn : +1 for an axis along y, -1 for the opposite axis
    """
    if gear.web_ratio >= 1.0 - _CLOSE:
        return None
    half = gear.web_ratio * gear.face_width / 2
    middle = turn * gear.web_offset
    return middle - half, middle + half


def even_about_mid_face(pair: GearPair) -> bool:
    """Whether both bodies are symmetric under half a turn about a radial axis at mid face."""
    return all(web_ends(gear, 1) == web_ends(gear, -1) for gear in (pair.pinion, pair.wheel))


def axial_ends(face_width: float, elements: int, web: tuple[float, float] | None = None) -> np.ndarray:
    """Element ends along the face, m, with elements half as long at the free end faces; they include the ends of a web.

    Parameters
    ----------
    face_width : m
    elements : over a face without a web; next to and above a web their share, rounded up
    web : ends of the web, m
    """
    fine = np.linspace(-1.0, 1.0, 2001)
    joints = [-1.0, 1.0]
    if web is not None:
        inner = np.interp(np.array(web) / (face_width / 2), fine + _GRADING * np.sin(np.pi * fine), fine)
        joints[1:1] = [place for place in inner if abs(place) < 1.0 - _CLOSE]
    parts = [
        np.linspace(low, high, math.ceil(elements * (high - low) / 2 - 1e-9) + 1)
        for low, high in zip(joints[:-1], joints[1:], strict=True)
    ]
    place = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
    ends = face_width / 2 * (place + _GRADING * np.sin(np.pi * place))
    for end in web or ():  # exact, not interpolated
        ends[np.abs(ends - end).argmin()] = end
    return ends
