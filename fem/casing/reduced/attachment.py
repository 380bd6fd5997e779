"""Rows that read the motion of a point off the mesh: mean motion of a patch, displacement of a surface point.

Mean motion (RBE3-like, adds no stiffness): translation t and small rotation r of a patch minimise

    int |u - t - r x (x - x0)|^2 dA,   so   [t, r] = G^-1 int R^T N dA u,   G = int R^T R dA,   R = [1, -(x - x0) x]

with the consistent weights of six-node facets. Rigid motions are reproduced exactly. By virtue of the transposed
rows a force or moment at the point becomes tractions on the patch that vary linearly over it.

Reference: MSC Nastran Linear Static Analysis User's Guide, element RBE3.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fem.elements.tetrahedra import rigid_body_modes

AXES = ("ux", "uy", "uz", "rx", "ry", "rz")
FARTHEST_SENSOR = 0.05  # m: a sensor farther than this from the surface is a mistake in the scene


class AttachmentError(ValueError):
    """A point cannot be tied to the mesh."""


def triangle_rule(n: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Jacobi product rule on the unit triangle, n^2 points, exact to degree 2n - 1 (Stroud, 1971)."""
    from scipy.special import roots_jacobi

    (a, wa), (b, wb) = roots_jacobi(n, 1.0, 0.0), roots_jacobi(n, 0.0, 0.0)
    a, b = (a + 1.0) / 2.0, (b + 1.0) / 2.0
    x, y = np.meshgrid(a, b, indexing="ij")
    return np.column_stack([x.ravel(), (y * (1.0 - x)).ravel()]), np.outer(wa / 4.0, wb / 2.0).ravel()


def facet_shape(points: np.ndarray) -> np.ndarray:
    """Shape functions of the six-node triangle (corners, then 01 12 20) at (q, 2) -> (q, 6)."""
    c = np.column_stack([1.0 - points.sum(axis=1), points])
    return np.hstack([c * (2.0 * c - 1.0), 4.0 * c * np.roll(c, -1, axis=1)])


def _facet_gradients(points: np.ndarray) -> np.ndarray:
    c, slope = np.column_stack([1.0 - points.sum(axis=1), points]), np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    after, slope_after = np.roll(c, -1, axis=1), np.roll(slope, -1, axis=0)
    sides = 4.0 * (c[:, :, None] * slope_after + after[:, :, None] * slope)
    return np.concatenate([(4.0 * c - 1.0)[:, :, None] * slope, sides], axis=1)


def surface_weights(nodes: np.ndarray, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Quadrature on a patch: shape functions (q, 6), points (f, q, 3) and area weights (f, q), m2."""
    points, weights = triangle_rule()
    values, gradients = facet_shape(points), _facet_gradients(points)
    coordinates = nodes[facets]
    tangents = np.einsum("qar,fad->fqrd", gradients, coordinates, optimize=True)
    area = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2) * weights
    return values, np.einsum("qa,fad->fqd", values, coordinates, optimize=True), area


def mean_motion_rows(nodes: np.ndarray, facets: np.ndarray, centre: np.ndarray) -> sp.csr_matrix:
    """Rows (6, 3 node) of the mean motion ux uy uz rx ry rz of a patch about `centre`.

    Parameters
    ----------
    nodes : float (node, 3), m
    facets : int (f, 6), the patch
    centre : float (3,), m, point whose translation is meant

    Raises
    ------
    AttachmentError : the patch is empty or too small to define a rotation (a line or a point)
    """
    if not len(facets):
        raise AttachmentError(f"patch at {_place(centre)} has no facet; refine the mesh")
    values, places, area = surface_weights(nodes, facets)
    motion = rigid_body_modes(places.reshape(-1, 3), centre).reshape(*area.shape, 3, 6)
    gram = np.einsum("fq,fqdi,fqdj->ij", area, motion, motion, optimize=True)
    size = np.sqrt(np.trace(gram[3:, 3:]) / gram[0, 0])  # length that makes rotations comparable
    scale = np.array([1.0, 1.0, 1.0, size, size, size])
    if not (size > 0.0 and np.linalg.cond(gram / np.outer(scale, scale)) < 1e10):
        raise AttachmentError(f"patch at {_place(centre)} is too small to define its rotation; refine the mesh")
    load = np.einsum("fq,qa,fqdi->ifad", area, values, motion, optimize=True)
    weights = np.linalg.solve(gram, load.reshape(6, -1))
    columns = (3 * facets[:, :, None].astype(np.int64) + np.arange(3)).ravel()
    rows = np.repeat(np.arange(6), columns.size)
    return sp.coo_matrix((weights.ravel(), (rows, np.tile(columns, 6))), shape=(6, 3 * len(nodes))).tocsr()


def nearest_surface_point(
    nodes: np.ndarray, facets: np.ndarray, position: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The point of the surface nearest to `position`.

    Returns
    -------
    corners : int (6,), nodes of its facet
    weights : float (6,), shape functions there: u = weights @ u[corners]
    point : float (3,), m

    Raises
    ------
    AttachmentError : the surface is farther away than `FARTHEST_SENSOR`
    """
    position = np.asarray(position, float)
    local = _nearest_in_triangles(nodes[facets[:, :3]], position)
    values = facet_shape(local)
    points = np.einsum("fa,fad->fd", values, nodes[facets])
    distance = np.linalg.norm(points - position, axis=1)
    best = int(distance.argmin())
    if distance[best] > FARTHEST_SENSOR:
        raise AttachmentError(
            f"sensor at {_place(position)} is {1000 * distance[best]:.4g} mm from the casing surface "
            f"(limit {1000 * FARTHEST_SENSOR:g} mm); the nearest surface point is {_place(points[best])}"
        )
    return facets[best], values[best], points[best]


def _nearest_in_triangles(corners: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Reference coordinates (f, 2) of the nearest point of each flat triangle (f, 3, 3)."""
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
    return np.where(contained[:, None], inside, edge)


def _place(point: np.ndarray) -> str:
    return f"x=({', '.join(f'{value:.4g}' for value in point)}) m"
