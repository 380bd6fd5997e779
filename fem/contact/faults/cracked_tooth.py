"""A crack in the root fillet: it adds the compliance that finite elements find between the slit and the welded section.

Slices are whole: the extent along the face is rounded to slices, an error of half a slice at most.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.contact.faults.crack_modes import crack_modes
from fem.contact.faults.cracked_beam import cracked_beam_compliance
from fem.contact.faults.tooth_fault import ToothFault, check_end, from_end
from fem.contact.frame import law_points
from fem.contact.law import MeshLaw
from fem.contact.wheels.crack_surface import DEEPEST, CrackSurface
from fem.contact.wheels.ring import FlankCompliance, changed_tooth, flank_loads, reduce_sector, ring_response
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.gears.path import PathPoints
from fem.gears.rack import require
from fem.gears.sector import Slit, root_chord, sector_mesh
from fem.storage.ledger import count

ANGLES = (math.radians(40.0), math.radians(90.0))


@dataclass(frozen=True, kw_only=True)
class CrackedTooth(ToothFault):
    """A crack in the root fillet of one flank: `depth` (m) along it, `angle` to the tooth's centre line (rad).

    The depth goes evenly over to `far_depth` (m) at the far end of the extent, None: the same depth. 0: a crack across
    a corner.

    It starts where the fillet runs at 45 degrees to the radius; angle pi/2 goes straight across the tooth, less goes
    down into the rim. `extent` (m) of the face from `end`, None: the whole face. flank "drive" or "coast": the side of
    the mouth. Under load on the other flank the crack is pressed shut and does nothing.
    """

    depth: float
    far_depth: float | None = None
    angle: float = math.radians(70.0)
    extent: float | None = None
    end: str = "+y"
    flank: str = "drive"

    def check(self, gear: Gear) -> None:
        """Raises GeometryError for a crack that is none or nearly cuts the tooth or the rim off."""
        label = f"cracked tooth of gear z={gear.teeth}"
        check_end(label, self.end)
        require(self.flank in ("drive", "coast"), f"{label}: flank is {self.flank!r}; choose 'drive' or 'coast'")
        low, high = ANGLES
        require(
            low - 1e-9 <= self.angle <= high + 1e-9,
            f"{label}: angle_deg = {math.degrees(self.angle):.4g} is outside the limits. Set {math.degrees(low):.0f} "
            "to "
            f"{math.degrees(high):.0f}",
        )
        radius, chord = root_chord(gear)
        require(
            0.0 < self.depth <= DEEPEST * chord,
            f"{label}: depth_mm = {1000 * self.depth:.4g} is more than {DEEPEST} of the tooth root thickness of "
            f'{1000 * chord:.4g} mm. Set at most {1000 * DEEPEST * chord:.4g}, or kind = "missing-tooth"',
        )
        far = self.depth if self.far_depth is None else self.far_depth
        require(
            0.0 <= far <= DEEPEST * chord,
            f"{label}: far_depth_mm = {1000 * far:.4g} is more than {DEEPEST} of the tooth root thickness. Set 0 to "
            f"{1000 * DEEPEST * chord:.4g}, or delete it",
        )
        deepest = max(self.depth, far)
        mouth = math.asin(chord / 2 / radius)
        tip = math.hypot(
            radius * math.cos(mouth) - deepest * math.cos(self.angle), chord / 2 - deepest * math.sin(self.angle)
        )
        floor = gear.rim_inner_radius + 0.3 * (gear.root_radius - gear.rim_inner_radius)
        require(
            tip >= floor,
            f"{label}: the crack ends at the diameter {2000 * tip:.6g} mm; it must end above {2000 * floor:.6g} mm, "
            "which "
            "leaves 30 % of the rim. Reduce depth_mm or raise angle_deg",
        )
        require(
            self.extent is None or 0.0 < self.extent <= gear.face_width,
            f"{label}: extent_mm = {1000 * (self.extent or 0.0):.4g} is more than the face width. Set at most "
            f"{1000 * gear.face_width:.4g}, or delete it for the whole face",
        )

    def reach(self, face_width: float) -> tuple[float, float]:
        """Both ends (m) of the cracked part of the face, rising."""
        half = face_width / 2
        extent = face_width if self.extent is None else self.extent
        return (half - extent, half) if self.end == "+y" else (-half, extent - half)

    def depth_at(self, face: np.ndarray, face_width: float) -> np.ndarray:
        """Depth (m) at face coordinates, 0 beyond the cracked part."""
        extent = face_width if self.extent is None else self.extent
        far = self.depth if self.far_depth is None else self.far_depth
        inwards = from_end(face, face_width, self.end)
        return np.where(inwards <= extent * (1 + 1e-12), self.depth + (far - self.depth) * inwards / extent, 0.0)

    def compliance(self, law: MeshLaw, pair: GearPair, gear: str) -> np.ndarray:
        """Compliance (slice, position), m2/N, in the slices that the crack reaches, on the flank of its mouth.

        Every slice has that of the plane crack of its own depth: the sound part of the face lends it no support.
        """
        added = super().compliance(law, pair, gear)
        if self.flank == law.flank:
            points = law_points(law, pair)
            plane = cracked_beam_compliance if law.model == "energy" else crack_compliance
            depths = self.depth_at(law.face_coordinate, pair.face_width)
            for depth in np.unique(depths[depths > 0.0]):
                added[depths == depth] += plane(pair, gear, depth, self.angle, points)
        return added

    @property
    def surface_angle(self) -> float:
        """Its angle."""
        return self.angle

    def modes(self, law: MeshLaw, pair: GearPair, gear: str, surface: CrackSurface) -> np.ndarray:
        """Modes of the opening; none on the other flank, which presses the crack shut.

        Parameters
        ----------
        law, pair, gear, surface : those of `ToothFault.modes`
        """
        if self.flank != law.flank:
            return super().modes(law, pair, gear, surface)
        face = pair.face_width
        return crack_modes(law, pair, gear, lambda y: self.depth_at(y, face), self.reach(face), surface)

    def movement(self, pair: GearPair, approach: float, *, alone: bool) -> None:
        """Not estimated: it depends on the depth far from evenly."""


def crack_compliance(
    pair: GearPair,
    gear: str,
    depth: float,
    angle: float,
    points: PathPoints,
    refinement: float = 1.0,
    patch: float = 0.08,
) -> np.ndarray:
    """Compliance (position,), m2/N, that a root crack adds at the contact points, per unit face width.

    Difference between a ring with the cracked tooth and the sound ring, both of the plane model and on one mesh, so
    that it vanishes with the crack.

    Parameters
    ----------
    pair : the gears in mesh
    gear : "pinion" or "wheel"
    depth, angle : of the crack, m and rad
    points : contact points (position,), on the flank of its mouth
    refinement : of the section mesh, see `fem.gears.sector.sector_mesh`
    patch : half-width of the loads in m_n, which cancels
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
