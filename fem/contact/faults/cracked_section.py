"""Compliance added by a root crack: finite elements of the section with the slit, minus those without."""

from __future__ import annotations

import numpy as np

from fem.contact.wheels.ring import FlankCompliance, changed_tooth, flank_loads, reduce_sector, ring_response
from fem.gears.geometry import GearPair
from fem.gears.path import PathPoints
from fem.gears.sector_mesh import Slit, sector_mesh
from fem.storage.ledger import count


def crack_compliance(
    pair: GearPair,
    gear: str,
    depth: float,
    angle: float,
    points: PathPoints,
    refinement: float = 1.0,
    patch: float = 0.08,
) -> np.ndarray:
    """Compliance (position,), m2/N, added by a root crack at the contact points, per unit face width.

    It is the difference between a ring with the cracked tooth and the healthy ring, both by the plane model on one
    mesh, so that it vanishes with the crack.

    Parameters
    ----------
    pair : the gears in mesh
    gear : "pinion" or "wheel"
    depth, angle : of the crack, m and rad
    points : contact points (position,), on the flank of the crack mouth
    refinement : of the section mesh, see `fem.gears.sector_mesh.sector_mesh`
    patch : half-width of the loads in m_n; its effect cancels
    """
    from threadpoolctl import threadpool_limits

    own, material = getattr(pair, gear), getattr(pair, f"{gear}_material")
    young, poisson = material.elastic_modulus, material.poisson_ratio
    mesh = sector_mesh(own, refinement, Slit(depth=depth, angle=angle))
    whole = mesh.closed()
    count("gear_meshes")
    with threadpool_limits(1):
        sound = reduce_sector(whole, young, poisson, flank_loads(whole))
        split = reduce_sector(mesh, young, poisson, flank_loads(mesh))
        added = changed_tooth(sound, split) - ring_response(sound, 0)[0]
    ring = FlankCompliance(arc=mesh.flank_arc, tip_arc=mesh.tip_arc, matrix={0: added})
    radius = points.pinion_radius if gear == "pinion" else points.wheel_radius
    centre = (radius**2 - own.base_radius**2).clip(0.0) / (2 * own.base_radius)
    weight, _ = ring.patches(centre, patch * own.normal_module)
    return np.maximum(np.einsum("pi,ij,pj->p", weight, added, weight), 0.0)
