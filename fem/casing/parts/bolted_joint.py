"""Bolted joint between two halves of a casing: closed in a ring around every bolt, open elsewhere.

A preloaded joint stays closed where the pressure cone of a bolt meets the contact plane, between the hole and the
diameter of the cone there; outside, the halves may separate and slide. In the ring of area A uniformly distributed
springs connect them,

    K = int N^T [k_n n n^T + k_t (1 - n n^T)] N dA / A,      N u = u_above - u_below

with k_n from the deformation cone (`fem.casing.parts.bolts`) and k_t = k_n 2 (1 - nu)/(2 - nu), the ratio for a
sticking contact area (Mindlin 1949, J. Appl. Mech. 16, 259-268). A common rigid motion of both halves strains no
spring.

The cone represents the resilience of the parts between head and nut. The elements of both halves contain most of it
already, so these springs are too soft; with ten times the stiffness the elements dominate. Still stiffer springs close
every facet that the ring touches, and the result depends on the mesh. The model excludes joints that open beyond their
rings, or slip, as they are nonlinear. Between the rings the halves may penetrate each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fem.casing.mesh.mesh import MeshError
from fem.casing.parts.bolts import Bolt
from fem.casing.parts.split_mesh import SplitMesh, SplitPlane
from fem.elements.facets import facet_element
from fem.elements.materials import Material
from fem.elements.solid_elements import shapes
from fem.numerics.message_places import in_mm

_FINE = 12  # pieces along the side of a facet; those within the ring are integrated


@dataclass(frozen=True, kw_only=True)
class BoltedJoint:
    """Equal bolts across a plane; `places` (m) are points on their axes, which are normal to it.

    `stiffness` (N/m, normal and tangential, per bolt) replaces that of the deformation cone.
    """

    plane: SplitPlane
    bolt: Bolt
    places: tuple[tuple[float, float, float], ...]
    stiffness: tuple[float, float] | None = None

    def stiffness_in(self, material: Material) -> tuple[float, float]:
        """Stiffness of every bolt along and across its axis, N/m, for clamped parts of a material."""
        if self.stiffness is not None:
            return self.stiffness
        normal, nu = self.bolt.stiffness(material.elastic_modulus), material.poisson_ratio
        return normal, normal * 2.0 * (1.0 - nu) / (2.0 - nu)


def contact_areas(joint: BoltedJoint, split: SplitMesh) -> np.ndarray:
    """Contact area (bolt,) around each bolt, m2; smaller than its ring where the contact plane ends."""
    points, weights, _, _ = _pieces(split)
    return np.array([float(weights[_inside(joint, np.array(place), points)].sum()) for place in joint.places])


def _inside(joint: BoltedJoint, place: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Whether points (q, 3) of the contact plane are in the ring of a bolt."""
    off, normal = points - place, np.array(joint.plane.normal)
    radius = np.linalg.norm(off - np.outer(off @ normal, normal), axis=1)
    return np.asarray((radius > joint.bolt.hole / 2.0) & (radius < joint.bolt.contact_diameter / 2.0))


def joint_stiffness(joint: BoltedJoint, split: SplitMesh, material: Material) -> sp.csr_matrix:
    """Stiffness (3 node, 3 node) of all bolts, N/m.

    Parameters
    ----------
    joint, split, material : the bolts, the two halves, and their material

    Raises
    ------
    MeshError : a bolt around which the halves do not touch
    """
    points, weights, values, numbers = _pieces(split)
    nodes = split.mesh.nodes
    normal = np.array(joint.plane.normal)
    along, across = joint.stiffness_in(material)
    density = np.zeros(len(points))
    for number, place in enumerate(np.array(joint.places), 1):
        ring = _inside(joint, place, points)
        if not ring.any():
            raise MeshError(
                f"casing joint: the halves do not touch around bolt {number} at {in_mm(place)}, "
                f"between diameters {1000 * joint.bolt.hole:.4g} and {1000 * joint.bolt.contact_diameter:.4g} mm; move "
                "the bolt"
            )
        density[ring] += weights[ring] / weights[ring].sum()
    used = np.flatnonzero(density)
    row = np.repeat(np.arange(len(used)), values.shape[1])
    shape = (len(used), len(nodes))
    facet = numbers[used]
    apart = sp.csr_matrix((values[used].ravel(), (row, split.above[facet].ravel())), shape=shape)
    apart -= sp.csr_matrix((values[used].ravel(), (row, split.below[facet].ravel())), shape=shape)
    held = sp.csr_matrix(apart.T @ sp.diags_array(density[used]) @ apart)
    tensor = across * np.eye(3) + (along - across) * np.outer(normal, normal)
    return sp.csr_matrix(sp.kron(held, tensor))


def _pieces(split: SplitMesh) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Centres (q, 3) of small pieces of the contact plane, their areas (q,), shape functions (q, k) and facets (q,)."""
    element = facet_element(split.above)
    local, share = _middles(element.refdom.nnodes)
    values, slopes = shapes(element, local)
    corners = split.mesh.nodes[split.above]
    tangents = np.einsum("qar,fad->fqrd", slopes, corners, optimize=True)
    areas = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2) * share
    count = len(corners)
    return (
        (values @ corners).reshape(-1, 3),
        areas.ravel(),
        np.tile(values, (count, 1)),
        np.repeat(np.arange(count), values.shape[0]),
    )


def _middles(corners: int) -> tuple[np.ndarray, float]:
    """Centres (2, q) of equal pieces of the reference triangle or square, and the area of one."""
    step = (np.arange(_FINE) + 0.5) / _FINE
    if corners == 4:
        return np.array(np.meshgrid(step, step)).reshape(2, -1), 1.0 / _FINE**2
    i, j = np.array([(i, j) for i in range(_FINE) for j in range(_FINE - i)]).T
    upright = (np.array([i, j]) + 1.0 / 3.0) / _FINE
    inner = i + j < _FINE - 1
    turned = (np.array([i[inner], j[inner]]) + 2.0 / 3.0) / _FINE
    return np.hstack([upright, turned]), 0.5 / _FINE**2
