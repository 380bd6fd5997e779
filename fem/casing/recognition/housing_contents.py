"""Recognised contents of a housing file, in the frame of the file, in metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False, kw_only=True)
class FoundSolid:
    """A body: its number from 1, volume (m3), corners of its box (2, 3) m, and the number of its part.

    Touching solids form one part; a file of one part is a connected body. `open_at` (3,) m is a position where its
    faces do not close or cannot be meshed; None for a closed body.
    """

    number: int
    volume: float
    box: np.ndarray
    part: int
    open_at: np.ndarray | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class FoundBore:
    """A cylindrical hole."""

    number: int
    solid: int
    axis: np.ndarray  # (3,), unit length, its largest component positive
    centre: np.ndarray  # (3,) m, on the axis in the middle of its length
    diameter: float  # m
    length: float  # m, along the axis
    angle: float  # rad, covered of a full turn

    @property
    def ends(self) -> np.ndarray:
        """End points (2, 3) of the axis inside the bore, m."""
        return self.centre + 0.5 * self.length * np.outer([-1.0, 1.0], self.axis)


@dataclass(frozen=True, eq=False, kw_only=True)
class FlatFace:
    """A flat face: area (m2), its centroid (3,) m and its normal out of the material."""

    number: int
    solid: int
    area: float
    centre: np.ndarray
    normal: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class BoltPattern:
    """Equal parallel holes that begin in one plane, on a circle (diameter and centre, m) or not (diameter 0)."""

    bores: tuple[int, ...]
    hole_diameter: float
    circle_diameter: float
    centre: np.ndarray
    around: int  # number of the bore in its centre, 0 for none


@dataclass(frozen=True, eq=False, kw_only=True)
class GeometryContents:
    """Recognised contents of a file. `gaps` are (solid, solid, m, position (3,) m) of neighbours that do not touch."""

    name: str
    unit: str  # unit in which lengths were read
    declared: str  # unit that the file declares, "" for none
    points: np.ndarray  # (n, 3) m, of the surface
    triangles: np.ndarray  # (t, 3), seen from outside counter-clockwise
    solid: np.ndarray  # (t,), number of the solid of each triangle
    solids: tuple[FoundSolid, ...]
    gaps: tuple[tuple[int, int, float, np.ndarray], ...]
    bores: tuple[FoundBore, ...]  # the widest first
    flats: tuple[FlatFace, ...]  # the largest first
    patterns: tuple[BoltPattern, ...]

    @property
    def box(self) -> np.ndarray:
        """Lower and upper corner (2, 3), m."""
        return np.array([self.points.min(axis=0), self.points.max(axis=0)])

    @property
    def parts(self) -> int:
        """Number of parts that do not touch."""
        return len({solid.part for solid in self.solids})
