"""The solid elements for meshes of a body, based on scikit-fem: shapes, mappings, node order, quadrature.

A mesh consists of nodes (n, 3) and elements (e, k); k identifies the element. Within an element the nodes are in the
order of scikit-fem (that of VTK for tetrahedra): corners, edges, faces, interior. `SolidElement.in_vtk` reorders
hexahedra.

Every element is isoparametric: the same shape functions describe displacement and geometry, so that a body may be
curved. Tetrahedra with straight sides have an affine map, which is exact and several times faster.

Quadrature rules are exact up to degree 2 on straight tetrahedra (exact stiffness of ten nodes), up to degree 8 on
curved ones, and up to degree 5 in each direction on hexahedra (three Gauss points). On curved tetrahedra the mass is
exact, and the error of the stiffness is 1e-7 of its largest entry (elements of 20 mm around bores of 40 mm).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from fem.numerics.message_places import in_mm

AXES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # i, j of the gradient products; j, i: transposed
STRAIGHT_RULE = 2
CURVED_RULE = 9  # exact to degree 8: from 5 on, scikit-fem's rules on tetrahedra are exact to one degree less
_HEXAHEDRON_RULE = 5
_STRAIGHT = 1e-9  # of the size of an element: tolerance of mid-side nodes on straight sides
_CHUNK = 16384  # quadrature points evaluated together: bounds the memory of the element loop


class ElementError(ValueError):
    """An element is inverted or unknown, or a material constant is outside its physical range."""


@dataclass(frozen=True)
class SolidElement:
    """A solid element; it represents all polynomials of degree `degree`.

    A scene may request it if it is `offered`. `instead` names an element to use if the discretisation error must be
    estimated; "": that of this element is.

    `tetrahedron-20` and `hexahedron-32` have the geometry of 10 and 20 nodes; `fem.elements.cubic` adds functions.
    """

    name: str
    nodes: int
    corners: int
    degree: int
    meshio: str
    mesh: str  # class of scikit-fem
    instead: str = ""
    offered: bool = True

    @property
    def mesh_type(self) -> Any:
        """Class of its meshes in scikit-fem."""
        import skfem

        return _serendipity_mesh() if self.mesh == "MeshHexS2" else getattr(skfem, self.mesh)

    @property
    def library(self) -> Any:
        """The element in scikit-fem."""
        return self.mesh_type.elem()

    @property
    def frequency_order(self) -> int:
        """Order of the errors of natural frequencies and strain energy in smooth bodies, twice that of strains."""
        return 2 * self.degree

    @property
    def in_vtk(self) -> np.ndarray:
        """Local numbers (k,) of the nodes in the order of VTK: elements[:, in_vtk] are written to files."""
        if self.corners == 4:
            return np.arange(self.nodes)
        ours = [tuple(place) for place in self.library.doflocs.tolist()]
        return np.array([ours.index(place) for place in _vtk_places()[: self.nodes]])


SOLIDS = {
    one.name: one
    for one in (
        SolidElement("tetrahedron-4", 4, 4, 1, "tetra", "MeshTet1", instead="tetrahedron-10"),
        SolidElement("tetrahedron-10", 10, 4, 2, "tetra10", "MeshTet2"),
        SolidElement("tetrahedron-20", 10, 4, 3, "tetra10", "MeshTet2"),  # cubic, geometry of ten nodes
        SolidElement("hexahedron-8", 8, 8, 1, "hexahedron", "MeshHex1", instead="hexahedron-32", offered=False),
        SolidElement("hexahedron-20", 20, 8, 2, "hexahedron20", "MeshHexS2", instead="hexahedron-32"),
        SolidElement("hexahedron-27", 27, 8, 2, "hexahedron27", "MeshHex2", instead="hexahedron-32"),
        SolidElement("hexahedron-32", 20, 8, 3, "hexahedron20", "MeshHexS2"),  # cubic, geometry of 20 nodes
    )
}
CHOICES = tuple(one.name for one in SOLIDS.values() if one.offered)  # hexahedron-8 locks
_BY_NODES = {one.nodes: one for one in SOLIDS.values() if one.degree < 3}
_LINEAR = {4: SOLIDS["tetrahedron-4"], 8: SOLIDS["hexahedron-8"]}  # by corners


def solid_element(elements: np.ndarray) -> SolidElement:
    """The element of a mesh, from its number of nodes. ElementError if there is none."""
    if elements.shape[1] not in _BY_NODES:
        raise ElementError(f"elements of {elements.shape[1]} nodes are unknown; {sorted(_BY_NODES)} are known")
    return _BY_NODES[elements.shape[1]]


def solid_mesh(nodes: np.ndarray, elements: np.ndarray) -> Any:
    """The mesh in scikit-fem, elements in the same order, nodes renumbered; every node must be used."""
    return solid_element(elements).mesh_type(np.array(nodes.T, float, order="C"), np.array(elements.T, order="C"))


def converted(nodes: np.ndarray, elements: np.ndarray, wanted: SolidElement) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and elements converted to another element of the same shape, numbered by scikit-fem: corners first.

    The given elements map the positions of added nodes; without the dropped nodes sides become straighter.
    """
    given = solid_element(elements)
    used, flat = np.unique(elements, return_inverse=True)
    mesh = solid_mesh(nodes[used], flat.reshape(elements.shape))
    if given.mesh != wanted.mesh:
        mesh = wanted.mesh_type.from_mesh(mesh)
    return mesh.doflocs.T.copy(), mesh.dofs.element_dofs.T.copy()


def shapes(element: Any, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Shape functions (q, a) and their local derivatives (q, a, d) of an element of scikit-fem at points (d, q)."""
    found = [element.lbasis(points, number) for number in range(len(element.doflocs))]
    count = points.shape[1]
    values = np.stack([np.broadcast_to(value, count) for value, _ in found], axis=1)
    slopes = np.stack([np.stack([np.broadcast_to(d, count) for d in slope], axis=1) for _, slope in found], axis=1)
    return values, slopes


def rule(element: Any, degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (d, q) and weights (q,) of scikit-fem on an element, for the requested degree."""
    from skfem.quadrature import get_quadrature

    return get_quadrature(element, degree)


def straight_places(nodes: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Positions of the nodes (e, k, 3) for straight sides between the corners of their elements."""
    kind = solid_element(elements)
    values, _ = shapes(_LINEAR[kind.corners].library, kind.library.doflocs.T)
    return values @ nodes[elements[:, : kind.corners]]


def curved(nodes: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Bool (element,): whether a side or face is curved."""
    off = np.linalg.norm(nodes[elements] - straight_places(nodes, elements), axis=2).max(axis=1)
    return off > _STRAIGHT * np.ptp(nodes[elements[:, : solid_element(elements).corners]], axis=1).max(axis=1)


@dataclass(frozen=True, eq=False)
class Cells:
    """Elements with the same kind of mapping and the same rule."""

    numbers: np.ndarray  # (e,)
    affine: bool
    values: np.ndarray  # (q, a)
    volume: np.ndarray  # (e, q), m3
    _slopes: np.ndarray
    _mapping: Any
    _points: np.ndarray

    def gradients(self) -> np.ndarray:
        """Gradients of the shape functions in space, (e, q, a, 3)."""
        inverse = self._mapping.invDF(self._points, self.numbers)  # d reference_r / d x_d, (3, 3, e, q)
        return np.einsum("qar,rdeq->eqad", self._slopes, inverse, optimize=True)

    def places(self) -> np.ndarray:
        """Positions of the quadrature points in space, (3, e, q)."""
        return self._mapping.F(self._points, self.numbers)


def cells(nodes: np.ndarray, elements: np.ndarray) -> Iterator[Cells]:
    """All elements of a mesh with their quadrature, a bounded number at a time.

    Raises
    ------
    ElementError : inverted elements, with the position of the worst
    """
    from skfem.mapping import MappingAffine, MappingIsoparametric  # not mesh.mapping(), which stores every Jacobian

    kind, mesh = solid_element(elements), solid_mesh(nodes, elements)
    library = kind.library
    straight = ~curved(nodes, elements) if kind.corners == 4 else np.zeros(len(elements), bool)
    bent_rule = CURVED_RULE if kind.corners == 4 else _HEXAHEDRON_RULE
    for affine, chosen, degree in ((True, straight, STRAIGHT_RULE), (False, ~straight, bent_rule)):
        points, weights = rule(library, degree)
        values, slopes = shapes(library, points)
        members = np.flatnonzero(chosen)
        for part in np.array_split(members, -(-len(members) * len(weights) // _CHUNK) or 1):
            if not len(part):
                continue
            mapping = MappingAffine(mesh, part) if affine else MappingIsoparametric(mesh, library)
            volume = weights * _determinant(nodes, elements, mapping, points, part)
            yield Cells(part, affine, values, volume, slopes, mapping, points)


def _determinant(
    nodes: np.ndarray, elements: np.ndarray, mapping: Any, points: np.ndarray, part: np.ndarray
) -> np.ndarray:
    """Jacobian determinants (e, q) of a part of the elements, all positive."""
    first, second, third = mapping.DF(points, part)  # rows d x_i / d reference, (3, e, q)
    found = (first * np.cross(second, third, axis=0)).sum(axis=0)
    if (bad := found <= 0.0).any():
        worst = int(np.argmin(found.min(axis=1)))
        kind = solid_element(elements)
        place = nodes[elements[part[worst], : kind.corners]].mean(axis=0)
        raise ElementError(
            f"{int(bad.any(axis=1).sum())} {kind.name} elements are inverted (Jacobian <= 0); the worst is element "
            f"{int(part[worst])} near {in_mm(place)} with {found.min():.3g} m3. "
            "Use a smaller element size, straight sides, or check the order of the nodes"
        )
    return found


def _vtk_places() -> list[tuple[float, ...]]:
    """Nodes of VTK's triquadratic hexahedron in the unit cube; scikit-fem's order for files would invert cells.

    Reference: VTK, class vtkTriQuadraticHexahedron; the first 8 and 20 are those of its smaller hexahedra.
    """
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    low, high = ([(x, y, z) for x, y in square] for z in (0, 1))
    ends = [*zip(low, low[1:] + low[:1], strict=True), *zip(high, high[1:] + high[:1], strict=True)]
    middles = np.mean([*ends, *zip(low, high, strict=True)], axis=1)
    faces = [0.5 + 0.5 * sign * np.eye(3)[axis] for axis in range(3) for sign in (-1, 1)]
    return [tuple(map(float, place)) for place in (*low, *high, *middles, *faces, (0.5, 0.5, 0.5))]


@cache
def _serendipity_mesh() -> Any:
    """Meshes of 20-node hexahedra: scikit-fem has the element, but no curved mesh for it."""
    from skfem import ElementHexS2, ElementQuadS2, MeshHex1

    @dataclass(repr=False)
    class MeshHexS2(MeshHex1):
        elem: type = ElementHexS2
        bndelem = ElementQuadS2()

    return MeshHexS2
