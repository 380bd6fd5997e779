"""Rows that give the motion of a point from the mesh: mean motion of a patch, displacement of a surface point.

Mean motion (RBE3-like, adds no stiffness): translation t and small rotation r of a patch minimise

    int |u - t - r x (x - x0)|^2 dA,   so   [t, r] = G^-1 int R^T N dA u,   G = int R^T R dA,   R = [1, -(x - x0) x]

with the consistent weights of the facets. Rigid motions are reproduced exactly. The transposed rows distribute a force
or moment at the point as tractions that vary linearly over the patch.

Reference: MSC Nastran Linear Static Analysis User's Guide, element RBE3.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fem.elements.facets import nearest_on_facets, surface_weights
from fem.elements.solids import rigid_body_modes
from fem.numerics.message_places import in_mm

AXES = ("ux", "uy", "uz", "rx", "ry", "rz")
FARTHEST_SENSOR = 0.05  # m: largest distance of a sensor from the surface


class AttachmentError(ValueError):
    """A point cannot be attached to the mesh."""


def mean_motion_rows(nodes: np.ndarray, facets: np.ndarray, centre: np.ndarray) -> sp.csr_matrix:
    """Rows (6, 3 node) of the mean motion ux uy uz rx ry rz of a patch about `centre`.

    Parameters
    ----------
    nodes : float (node, 3), m
    facets : int (f, k), the patch
    centre : float (3,), m, point of the translation

    Raises
    ------
    AttachmentError : the patch is too small to define a rotation (a line or a point)
    """
    values, places, area = surface_weights(nodes, facets)
    motion = rigid_body_modes(places.reshape(-1, 3), centre).reshape(*area.shape, 3, 6)
    gram = np.einsum("fq,fqdi,fqdj->ij", area, motion, motion, optimize=True)
    size = np.sqrt(np.trace(gram[3:, 3:]) / gram[0, 0])  # length that scales rotations
    scale = np.array([1.0, 1.0, 1.0, size, size, size])
    if not (size > 0.0 and np.linalg.cond(gram / np.outer(scale, scale)) < 1e10):
        raise AttachmentError(f"patch at {in_mm(centre)} is too small to define its rotation; refine the mesh")
    load = np.einsum("fq,qa,fqdi->ifad", area, values, motion, optimize=True)
    weights = np.linalg.solve(gram, load.reshape(6, -1))
    columns = (3 * facets[:, :, None].astype(np.int64) + np.arange(3)).ravel()
    rows = np.repeat(np.arange(6), columns.size)
    return sp.coo_matrix((weights.ravel(), (rows, np.tile(columns, 6))), shape=(6, 3 * len(nodes))).tocsr()


def nearest_surface_point(
    nodes: np.ndarray, facets: np.ndarray, position: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The point of the surface nearest to `position`; the nearest node if the body has only nodes.

    Returns
    -------
    corners : int (k,), nodes of its facet
    weights : float (k,), shape functions there: u = weights @ u[corners]
    point : float (3,), m

    Raises
    ------
    AttachmentError : the surface is farther away than `FARTHEST_SENSOR`
    """
    position = np.asarray(position, float)
    what, remedy = "point of the surface", "Move the sensor"
    if not len(facets):
        what = "node"
        remedy += ", or add a node at its place to the matrices (an export of gearcase has one at each sensor)"
        facets = np.arange(len(nodes))[:, None]
        values = np.ones((len(nodes), 1))
    else:
        values = nearest_on_facets(nodes, facets, position)
    points = np.einsum("fa,fad->fd", values, nodes[facets])
    distance = np.linalg.norm(points - position, axis=1)
    best = int(distance.argmin())
    if distance[best] > FARTHEST_SENSOR:
        raise AttachmentError(
            f"sensor at {in_mm(position)} is {1000 * distance[best]:.4g} mm from the nearest {what} of the casing at "
            f"{in_mm(points[best])} (limit {1000 * FARTHEST_SENSOR:g} mm). {remedy}"
        )
    return facets[best], values[best], points[best]
