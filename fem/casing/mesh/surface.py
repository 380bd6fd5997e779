"""The outer surface of a housing as corner triangles, on which key points are located."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from fem.numerics.connected_parts import connected_parts, shared_sides


@dataclass(frozen=True, eq=False)
class Surface:
    """Corner triangles of an outer surface."""

    points: np.ndarray  # (n, 3), m
    triangles: np.ndarray  # int (f, 3)
    groups: Mapping[str, np.ndarray] = field(default_factory=dict)  # bool (f,) by name

    @property
    def corners(self) -> np.ndarray:
        """Corner coordinates (f, 3, 3)."""
        return self.points[self.triangles]

    @property
    def area_vectors(self) -> np.ndarray:
        """Normal of each triangle times its area (f, 3), m2."""
        corners = self.corners
        return 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

    def parts(self, chosen: np.ndarray) -> list[np.ndarray]:
        """The chosen facets as sets (indices) connected over edges, in the order of their first facet."""
        facets = np.flatnonzero(chosen)
        if not len(facets):
            return []
        one, two = shared_sides(self.triangles[facets])
        label = connected_parts(len(facets), one // 3, two // 3)
        return [facets[label == number] for number in range(label.max() + 1)]
