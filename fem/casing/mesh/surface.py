"""The outer surface of a housing as corner triangles, on which key points are located."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


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
        from scipy.sparse import coo_matrix  # imported here so that commands that only read a scene start sooner
        from scipy.sparse.csgraph import connected_components

        facets = np.flatnonzero(chosen)
        if not len(facets):
            return []
        sides = np.sort(self.triangles[facets][:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        edge = np.unique(sides, axis=0, return_inverse=True)[1].ravel()
        owner = np.repeat(np.arange(len(facets)), 3)
        incidence = coo_matrix((np.ones(len(edge)), (owner, edge))).tocsr()
        label = connected_components(incidence @ incidence.T, directed=False)[1]
        return [facets[label == number] for number in range(label.max() + 1)]
