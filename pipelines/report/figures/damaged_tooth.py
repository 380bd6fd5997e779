"""Surface of a damaged tooth: its transverse section at stations along the face, changed by the damage.

Frame of the tooth: centre line of the section at mid face along x, y towards its drive flank, z along the face. The
section runs counter-clockwise, from the middle of one space over the coast flank, tip and drive flank to the next.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fem.gears.gear import Gear
from fem.gears.profile import half_tooth_profile
from pipelines.report.figures.tooth_surfaces import fanned, twist

WALL = 1e-5  # of the face width


@dataclass(frozen=True, eq=False, kw_only=True)
class DrawnTooth:
    """A damaged tooth in its frame; lengths in m."""

    points: np.ndarray  # (n, 3)
    quads: np.ndarray  # (q, 4)
    broken: np.ndarray  # (q,), faces of fracture
    depth: np.ndarray  # (n,), of material worn off, 0 where the tooth is undamaged
    sheets: tuple[np.ndarray, ...] = ()  # surfaces inside the tooth, each (row, column, 3)
    lines: tuple[np.ndarray, ...] = ()  # visible edges of cracks, each (point, 3)
    scale: float = 1.0  # factor by which the depth of wear is enlarged
    missing: bool = False
    end: int = 0  # end of the face nearest to the viewer: +1, -1, 0 either
    flank: int = 1  # visible flank: +1 drive, -1 coast
    words: str = ""  # description of the damage, for the legend


@dataclass(frozen=True, eq=False, kw_only=True)
class ToothSection:
    """Transverse section of a tooth without damage."""

    gear: Gear
    flank_points: int

    @cached_property
    def points(self) -> np.ndarray:
        """Of the section (k, 2), m."""
        half = half_tooth_profile(self.gear, n_fillet=10, n_flank=self.flank_points, n_tip=4)
        tooth = np.vstack([half[:-1], half[::-1] * [-1.0, 1.0]])
        return np.column_stack([tooth[:, 1], -tooth[:, 0]])

    @property
    def radius(self) -> np.ndarray:
        """Distance (k,) of its points from the axis."""
        return np.hypot(*self.points.T)


def stations(face_width: float, edges: Sequence[float] = (), count: int = 25) -> np.ndarray:
    """Face coordinates of `count` sections and more; at each of `edges` two that nearly coincide."""
    half, close = face_width / 2, 1e-6 * face_width
    inside = [edge + step for edge in edges for step in (-close, close) if abs(edge) < half - 2 * close]
    return np.unique(np.concatenate([np.linspace(-half, half, count), inside]))


def surface_of(
    section: ToothSection, face: np.ndarray, flat: np.ndarray, broken: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Closed surface of a tooth; its end faces are fans about the middle of its base.

    Parameters
    ----------
    section, face : the tooth and its stations (s,)
    flat : (s, k, 2), points of the section at every station
    broken : (s, k), points that fracture has moved

    Returns
    -------
    points (n, 3), quads (q, 4), and which of them are faces of fracture (q,)
    """
    points, quads = fanned(flat, twist(section.gear), face)
    after = np.roll(np.arange(flat.shape[1]), -1)
    step = np.diff(face)[:, None] < WALL * np.ptp(face)  # a wall is between stations that nearly coincide
    torn = np.where(step, broken[:-1] | broken[1:], broken[:-1] & broken[1:])
    torn = (torn & torn[:, after]).ravel()
    return points, quads, np.concatenate([torn, np.zeros(len(quads) - torn.size, dtype=bool)])


def cut_down(section: ToothSection, height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Section at stations without the material outside a radius.

    Parameters
    ----------
    section : the tooth
    height : (s,), remaining radius, m

    Returns
    -------
    points (s, k, 2), and which of them are on the fracture (s, k)
    """
    sound, radius = section.points, section.radius
    flat = np.repeat(sound[None], len(height), axis=0)
    broken = np.zeros(flat.shape[:2], dtype=bool)
    peak = int(np.argmax(radius))
    for row, left in enumerate(height):
        gone = np.flatnonzero(radius > left * (1 + 1e-9))
        if gone.size == 0:
            continue
        rising = slice(0, peak + 1)
        angle = np.arctan2(sound[:, 1], sound[:, 0])
        corner = abs(float(np.interp(left, radius[rising], angle[rising])))
        side = np.linspace(-corner, corner, gone.size)
        chord = left * math.cos(corner) * np.tan(side)
        flat[row, gone] = np.column_stack([np.full(gone.size, left * math.cos(corner)), chord])
        broken[row, gone] = True
    return flat, broken


def turned_in(points: np.ndarray, angle: float, centre: float) -> np.ndarray:
    """Points (..., 3) of a tooth whose centre line has turned to a polar angle about the axis through (centre, 0)."""
    cosine, sine = math.cos(angle), math.sin(angle)
    matrix = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return points @ matrix.T + [centre, 0.0, 0.0]
