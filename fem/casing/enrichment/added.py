"""What the elements of a casing are given beyond their nodes: cubic displacements, and functions of edges."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from fem.casing.enrichment.functions import edge_functions
from fem.casing.mesh.mesh import CasingMesh
from fem.elements.added_unknowns import AddedUnknowns, Together
from fem.elements.cubic import cubic_functions
from fem.elements.materials import Material


def added_functions(
    mesh: CasingMesh,
    material: Material,
    *,
    held: Collection[str],
    rigid: Collection[str] = (),
    joined: Sequence[np.ndarray] = (),
) -> AddedUnknowns:
    """Of a cubic mesh cubic ones, of hexahedra those of edges; none of others.

    Parameters
    ----------
    mesh, material : of the casing
    held, rigid : patches whose nodes are clamped, or move as a rigid body
    joined : facets (f, k) at which parts of the mesh touch without sharing nodes
    """
    if not mesh.cubic:
        return edge_functions(mesh, material, held=held, joined=joined)
    cubic = cubic_functions(mesh.nodes, mesh.elements, mesh.facets_of([*held, *rigid]), material)
    return Together.of([cubic, edge_functions(mesh, material, held=held, joined=joined, cubic=cubic)])
