"""What damage and modifications do to a mesh law: gaps and compliances, added to the tables of a sound pair.

A chip ends the flank in an edge at a lower radius: beyond it the pair goes on with the tip-edge contact of the short
tooth, slice by slice. A crack adds the compliance that finite elements find between the slit and the welded section,
in the slices that it reaches. Wear is a gap over the profile. Slices are whole: the extent of a chip or crack along the
face is rounded to slices, an error of half a slice at most.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fem.contact.law import MeshLaw
from fem.contact.teeth import with_variants
from fem.contact.wheels.ring import FlankCompliance, changed_tooth, flank_loads, reduce_sector, ring_response
from fem.gears.faults import ChippedTooth, CrackedTooth, Damage, WornTooth
from fem.gears.geometry import GearPair
from fem.gears.modifications import PairModifications, check_modifications, lead_gap, profile_gap
from fem.gears.path import PathPoints, path_points
from fem.gears.sector import Slit, sector_mesh
from fem.storage.ledger import count


def modified_law(law: MeshLaw, pair: GearPair, modifications: PairModifications) -> MeshLaw:
    """The law of the pair with its flanks modified and its axes misaligned; its compliances stay.

    Raises
    ------
    GeometryError : a modification that does not fit on the flanks
    """
    if modifications.none:
        return law
    check_modifications(pair, modifications)
    return law.replaced(
        gap=law.gap + profile_gap(pair, modifications, law_points(law, pair)),
        lead_gap=law.lead_gap + lead_gap(pair, modifications, law.flank, law.face_coordinate),
    )


def damaged_law(law: MeshLaw, pair: GearPair, gear: str, damage: Sequence[Damage], refinement: float = 1.0) -> MeshLaw:
    """The law with a variant of the teeth of "pinion" or "wheel" that carries all of `damage` at once.

    Raises
    ------
    GeometryError : damage that does not fit on the tooth
    """
    compliance = np.zeros((law.face_coordinate.size, law.compliance.size))
    gap = np.zeros_like(compliance)
    for one in damage:
        one.check(getattr(pair, gear))
        if isinstance(one, ChippedTooth):
            gap = gap + chip_gap(law, pair, gear, one)
        elif isinstance(one, WornTooth):
            gap = gap + wear_gap(law, pair, gear, one)
        elif one.flank == law.flank:
            reached = one.covers(law.face_coordinate, pair.face_width)
            compliance[reached] += crack_compliance(pair, gear, one, law_points(law, pair), refinement)
    return with_variants(law, gear, compliance, gap)


def law_points(law: MeshLaw, pair: GearPair) -> PathPoints:
    """The contact points of the pair at the positions of the law."""
    xi = law.position_start + law.position_step * np.arange(law.compliance.size)
    return path_points(pair, xi, pair.pinion.normal_module, (np.inf, np.inf))


def chip_gap(law: MeshLaw, pair: GearPair, gear: str, chip: ChippedTooth) -> np.ndarray:
    """Gap (slice, position), m, that a chip adds: 0 where the flank is left, inf where nothing can touch."""
    own = getattr(pair, gear)
    xi = law.position_start + law.position_step * np.arange(law.compliance.size)
    largest = 0.5 * pair.pinion.normal_module
    sound = path_points(pair, xi, largest, (np.inf, np.inf)).gap
    depths = chip.depth_at(law.face_coordinate, pair.face_width)
    added = np.zeros((depths.size, xi.size))
    for depth in np.unique(depths[depths > 0.0]):
        left = own.tip_radius - depth
        tips = (left, np.inf) if gear == "pinion" else (np.inf, left)
        short = path_points(pair, xi, largest, tips).gap
        with np.errstate(invalid="ignore"):
            more = np.where(np.isfinite(sound), short - sound, 0.0)
        added[depths == depth] = np.maximum(more, 0.0)
    return added


def wear_gap(law: MeshLaw, pair: GearPair, gear: str, wear: WornTooth) -> np.ndarray:
    """Gap (position,), m, by wear of one gear."""
    points, side = law_points(law, pair), 0 if gear == "pinion" else 1
    own = getattr(pair, gear)
    radius = points.pinion_radius if gear == "pinion" else points.wheel_radius
    roll = np.sqrt(np.maximum(radius**2 - own.base_radius**2, 0.0))
    root = min(pair.roll_lengths(xi)[side] for xi in (pair.xi_start, pair.xi_end))
    return wear.gap_at(roll, pair.roll_lengths(0.0)[side], root)


def crack_compliance(
    pair: GearPair, gear: str, crack: CrackedTooth, points: PathPoints, refinement: float = 1.0, patch: float = 0.08
) -> np.ndarray:
    """Compliance (position,), m2/N, that a root crack adds at the contact points, per unit face width.

    Difference between a ring with the cracked tooth and the sound ring, both of the plane rung and on one mesh, so that
    it vanishes with the crack. `patch` is the half-width of the loads in m_n, which cancels.
    """
    from threadpoolctl import threadpool_limits

    own, material = getattr(pair, gear), getattr(pair, f"{gear}_material")
    young, poisson = material.elastic_modulus, material.poisson_ratio
    mesh = sector_mesh(own, refinement, Slit(depth=crack.depth, angle=crack.angle))
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
