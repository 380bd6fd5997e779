"""CasingMesh: solid elements of a housing with the named patches of its surface."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.elements.cubic_shapes import CUBIC
from fem.elements.solid_elements import SolidElement, solid_element
from fem.storage.records import Record, array, integer, names, scalar, text


class MeshError(ValueError):
    """A casing mesh is too coarse, distorted, or lacks a requested surface."""


@dataclass(frozen=True, eq=False, kw_only=True)
class CasingMesh(Record):
    """Nodes, elements and surface of a casing; all steps after meshing need only this record."""

    nodes: np.ndarray = array("node", "axis", units="m")
    elements: np.ndarray = array("element", "corner", units="1", dtype=np.int32)  # see fem.elements.solid_elements
    facets: np.ndarray = array("facet", "facet_corner", units="1", dtype=np.int32)  # surface, see fem.elements.facets
    facet_patch: np.ndarray = array("facet", units="1", dtype=np.int32)  # index into patch_names, -1 elsewhere
    patch_names: tuple[str, ...] = names("patch")  # "ground_1", ..., "bearing_1", ...
    patch_points: np.ndarray = array("patch", "axis", units="m")  # reference point of each patch
    element_size: float = scalar(units="m")
    quality: float = scalar(units="1")  # worst signed inverse condition number, 1 is equilateral
    curved: int = integer()  # 1: mid-side nodes are on the curved surfaces
    cubic: int = dataclasses.field(default=0, metadata=integer().metadata)  # 1: `fem.elements.cubic` in every element
    straightened: int = dataclasses.field(default=0, metadata=integer().metadata)  # number of folded elements of a file
    divided: str = dataclasses.field(default="", metadata=text().metadata)  # of a file into tetrahedra, as text

    @property
    def element(self) -> SolidElement:
        """Element type of the mesh."""
        return CUBIC[self.elements.shape[1]] if self.cubic else solid_element(self.elements)

    def patch(self, name: str) -> np.ndarray:
        """Facets (f, k) of a patch; `MeshError` with the known names if absent or empty."""
        if name not in self.patch_names:
            raise MeshError(f"casing mesh: no patch {name!r}; known: {', '.join(self.patch_names)}")
        found = self.facets[self.facet_patch == self.patch_names.index(name)]
        if not len(found):
            raise MeshError(f"casing mesh: patch {name!r} has no facet; check the geometry or refine the mesh")
        return found

    def facets_of(self, names: Sequence[str]) -> np.ndarray:
        """Facets (f, k) of several patches; `MeshError` as `patch`."""
        return np.concatenate([self.facets[:0], *(self.patch(name) for name in names)])

    def point(self, name: str) -> np.ndarray:
        """Reference point (3,) of a patch."""
        self.patch(name)
        return self.patch_points[self.patch_names.index(name)]

    def patches(self, prefix: str) -> tuple[str, ...]:
        """Names of the patches that start with `prefix`, as stored: in numeric order."""
        return tuple(name for name in self.patch_names if name.startswith(prefix))
