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

    @property
    def normals(self) -> np.ndarray:
        """Unit normal of each triangle (f, 3); 0 for one without area."""
        vectors = self.area_vectors
        return vectors / np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)[:, None]

    def parts(self, chosen: np.ndarray, smooth: float = -2.0) -> list[np.ndarray]:
        """The chosen facets as sets (indices) connected over edges, in the order of their first facet.

        Parameters
        ----------
        chosen : bool (f,)
        smooth : least cosine between the normals of connected facets
        """
        facets = np.flatnonzero(chosen)
        if not len(facets):
            return []
        one, two = (sides // 3 for sides in shared_sides(self.triangles[facets]))
        normals = self.normals[facets]
        joined = np.einsum("fd,fd->f", normals[one], normals[two]) > smooth
        label = connected_parts(len(facets), one[joined], two[joined])
        return [facets[label == number] for number in range(label.max() + 1)]
