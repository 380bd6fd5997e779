"""A mesh split in two along a plane between its elements: every node on the plane is duplicated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.casing.mesh.mesh import CasingMesh, MeshError
from fem.elements.facets import outer_facets
from fem.elements.solid_elements import solid_element
from fem.numerics.message_places import in_mm

_IN_PLANE = 1e-3  # of the element size: largest distance of nodes from the plane


@dataclass(frozen=True, kw_only=True)
class SplitPlane:
    """A plane through a point (m); `normal` has unit length."""

    through: tuple[float, float, float]
    normal: tuple[float, float, float]

    def height(self, points: np.ndarray) -> np.ndarray:
        """Distance of points (..., 3) from the plane along its normal."""
        return np.asarray((points - np.array(self.through)) @ np.array(self.normal))


@dataclass(frozen=True, eq=False)
class SplitMesh:
    """Two halves with matching facets: the nodes `below` and `above` (f, k) coincide entry by entry."""

    mesh: CasingMesh
    below: np.ndarray
    above: np.ndarray


def split_mesh(mesh: CasingMesh, plane: SplitPlane) -> SplitMesh:
    """The mesh split into the elements above the plane (along its normal) and those below.

    Raises
    ------
    MeshError : elements on both sides of the plane, or no facet in it
    """
    height, near = plane.height(mesh.nodes), _IN_PLANE * mesh.element_size
    corners = height[mesh.elements[:, : solid_element(mesh.elements).corners]]
    crossed = (corners.min(axis=1) < -near) & (corners.max(axis=1) > near)
    where = f"casing joint in the plane through {in_mm(plane.through)}"
    if crossed.any():
        raise MeshError(
            f"{where}: {int(crossed.sum())} of {len(crossed)} elements cross this plane, one around "
            f"{in_mm(mesh.nodes[mesh.elements[crossed][0]].mean(axis=0))}. Set through_mm and normal of a plane that "
            "no element crosses (of a STEP file with glue = true: where two solids touch)"
        )
    upper = corners.mean(axis=1) > 0.0
    shared = np.intersect1d(mesh.elements[upper], mesh.elements[~upper])
    moved = np.arange(len(mesh.nodes))
    moved[shared] = len(mesh.nodes) + np.arange(len(shared))
    nodes = np.vstack([mesh.nodes, mesh.nodes[shared]])
    elements = np.where(upper[:, None], moved[mesh.elements], mesh.elements)
    origin = np.concatenate([np.arange(len(mesh.nodes)), shared])
    facets = outer_facets(nodes, elements)
    owner = {tuple(key): patch for key, patch in zip(_keys(mesh.facets), mesh.facet_patch.tolist(), strict=True)}
    keys = [tuple(key) for key in _keys(origin[facets])]
    inner = np.array([key not in owner for key in keys])
    above = facets[inner & (facets >= len(mesh.nodes)).all(axis=1)]
    if not len(above):
        raise MeshError(f"{where}: no facet of the mesh lies in it; correct the plane")
    return SplitMesh(
        mesh=mesh.replaced(
            nodes=nodes,
            elements=elements,
            facets=facets,
            facet_patch=np.array([owner.get(key, -1) for key in keys]),
        ),
        below=origin[above],
        above=above,
    )


def _keys(facets: np.ndarray) -> list[list[int]]:
    return np.sort(facets, axis=1).tolist()
