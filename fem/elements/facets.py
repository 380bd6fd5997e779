"""The surface of a solid mesh: its outer facets, integrals over them, and their triangles.

Facets (f, k) have 3 or 6 nodes (triangles) or 4, 8 or 9 (quadrilaterals) in the order of scikit-fem: corners, then
mid-sides 01 12 20 or 01 12 23 30, then the middle. Seen from outside the corners run counter-clockwise.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fem.elements.solid_elements import rule, shapes, solid_element, solid_mesh

_ELEMENTS = {3: "ElementTriP1", 6: "ElementTriP2", 4: "ElementQuad1", 8: "ElementQuadS2", 9: "ElementQuad2"}
_DEGREE = 7  # up to which integrals over facets are exact, in each direction
_TURNED = {3: [0, 2, 1], 6: [0, 2, 1, 5, 4, 3], 4: [0, 3, 2, 1]}
_TURNED |= {8: [*_TURNED[4], 7, 6, 5, 4], 9: [*_TURNED[4], 7, 6, 5, 4, 8]}
_CORNERS = {3: [[0, 1, 2]], 4: [[0, 1, 2], [0, 2, 3]]}
_DRAWN = {
    3: [[0, 1, 2]],
    6: [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
    8: [[0, 4, 7], [4, 1, 5], [5, 2, 6], [6, 3, 7], [4, 5, 7], [5, 6, 7]],
}
_DRAWN[9] = _DRAWN[8]


def facet_element(facets: np.ndarray) -> Any:
    """The element of scikit-fem on a facet, by its number of nodes."""
    import skfem

    return getattr(skfem, _ELEMENTS[facets.shape[1]])()


def outer_facets(nodes: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Facets (f, k) that belong to one element only, in the order in which scikit-fem numbers them."""
    mesh = solid_mesh(nodes, elements)
    number = np.empty(len(nodes), np.int64)
    number[mesh.dofs.element_dofs] = elements.T
    outer, parts = mesh.boundary_facets(), [mesh.facets]
    if solid_element(elements).degree > 1:
        parts.append(mesh.dofs.edge_dofs[0, mesh.f2e])
    if mesh.dofs.facet_dofs.size:
        parts.append(mesh.dofs.facet_dofs)
    facets = number[np.vstack([part[:, outer] for part in parts])].T
    corners = nodes[facets[:, : mesh.facets.shape[0]]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outwards = corners.mean(axis=1) - nodes[elements[mesh.f2t[0, outer]]].mean(axis=1)
    inwards = np.einsum("fd,fd->f", normal, outwards) < 0.0
    facets[inwards] = facets[inwards][:, _TURNED[facets.shape[1]]]
    return facets


def surface_weights(nodes: np.ndarray, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Quadrature on a patch: shape functions (q, k), points (f, q, 3) and area weights (f, q), m2."""
    element = facet_element(facets)
    points, weights = rule(element, _DEGREE)
    values, slopes = shapes(element, points)
    tangents = np.einsum("qar,fad->fqrd", slopes, nodes[facets], optimize=True)
    area = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2) * weights
    return values, values @ nodes[facets], area


def corner_triangles(facets: np.ndarray) -> np.ndarray:
    """Triangles (f, t, 3) between the corners of every facet: one, or two for a quadrilateral."""
    return facets[:, _CORNERS[3 if facets.shape[1] in (3, 6) else 4]]


def drawn_triangles(facets: np.ndarray) -> np.ndarray:
    """Triangles (t, 3) between all nodes on the sides of the facets, for plots of curved facets."""
    return facets[:, _DRAWN[facets.shape[1]]].reshape(-1, 3)


def nearest_on_facets(nodes: np.ndarray, facets: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Shape functions (f, k) at the point of every facet nearest to `position`, for straight sides."""
    element = facet_element(facets)
    triangles = np.array(_CORNERS[element.refdom.nnodes])
    best = np.full(len(facets), np.inf)
    local = np.zeros((2, len(facets)))
    for triangle in triangles:
        share, distance = nearest_in_triangles(nodes[facets[:, triangle]], position)
        nearer = distance < best
        best[nearer] = distance[nearer]
        local[:, nearer] = (element.refdom.p[:, triangle] @ share.T)[:, nearer]
    return shapes(element, local)[0]


def nearest_in_triangles(corners: np.ndarray, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Barycentric coordinates (f, 3) of the nearest point of each flat triangle (f, 3, 3), and its distance (f,)."""
    origin, a, b = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    offset = position - origin
    aa, ab, bb = (np.einsum("fd,fd->f", p, q) for p, q in ((a, a), (a, b), (b, b)))
    oa, ob = np.einsum("fd,fd->f", offset, a), np.einsum("fd,fd->f", offset, b)
    determinant = aa * bb - ab * ab
    inside = np.column_stack([(bb * oa - ab * ob) / determinant, (aa * ob - ab * oa) / determinant])
    on_a, on_b = np.clip(oa / aa, 0.0, 1.0), np.clip(ob / bb, 0.0, 1.0)
    on_c = np.clip((ob - oa + aa - ab) / (aa - 2.0 * ab + bb), 0.0, 1.0)
    zero = np.zeros_like(on_a)
    edges = np.stack([np.stack([on_a, zero], 1), np.stack([zero, on_b], 1), np.stack([1.0 - on_c, on_c], 1)])
    miss = edges[..., :1] * a + edges[..., 1:] * b - offset
    edge = np.take_along_axis(edges, np.linalg.norm(miss, axis=2).argmin(axis=0)[None, :, None], axis=0)[0]
    contained = (inside >= 0.0).all(axis=1) & (inside.sum(axis=1) <= 1.0)
    found = np.where(contained[:, None], inside, edge)
    distance = np.linalg.norm(found[:, :1] * a + found[:, 1:] * b - offset, axis=1)
    return np.column_stack([1.0 - found.sum(axis=1), found]), distance
