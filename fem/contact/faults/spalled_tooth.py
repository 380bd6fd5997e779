"""A spall: one patch broken out of a flank, see `fem.contact.faults.broken_patches`.

The mate is supported by the rim, a sharp edge that is softer than a flank. Both surfaces are taken as elastic
half-planes in contact over 0 < t < c from the rim, with the nominal contact at the distance s inside the spall (s < 0
outside). The pressure that is smooth at c, and the load, are

    p(t) = E* / (2 rho) sqrt((c - t) / t) (s + c/2 + t),            f = pi E* c / (4 rho) (s + 3 c / 4)

(Johnson 1985, Contact Mechanics, 2.7). With the half-width b of the Hertz contact of the same load, the approach
exceeds the sum of gap and Hertz approach by A f e, with A of the law and

    e = 1 - 3 kappa^2 / 4 + 2 ln(2 / kappa) + 2 min(s/b, 0)^2,    kappa = c / b = 2/3 (sqrt(s^2/b^2 + 3) - s/b)

e rises from 0 at s = -b, where the rim is at the end of the Hertz contact, and is 1.1 at s = 0.

The wall of the spall, of the depth d, makes the rim a quarter-plane. There a load at the apex and along one side causes
the displacement 4 pi / (pi^2 - 4) f / E' times the logarithm of the distance, in a half-plane 2 / pi f / E'
(Timoshenko & Goodier, Theory of Elasticity, art. 38). For the share 1 - kappa^2 / 4 of the load, which is that of the
singular pressure, the rim yields further by

    (4 pi / (pi^2 - 4) - 2 / pi) f / E' ln(1 + WALL d / c)

WALL is that of plane finite elements with this pressure (`benchmarks/spall_rim.py`): 1.7 at c = 4 d, 2.4 at c = d/50.

The compliances that a fault adds to a law do not depend on the load, so b is that of a usual flank pressure. A spall
that is lower than the Hertz contact is bridged by both rims: the compliance is reduced in proportion to its height, an
assumption that lets it vanish with the spall.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.contact.faults.broken_patches import FlankDamage, Patch, arc_at
from fem.contact.faults.gap_on_slices import face_parts
from fem.contact.faults.tooth_fault import lost_share
from fem.contact.law import MeshLaw
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.gears.path import path_points
from fem.options import option

USUAL_PRESSURE = 1500e6  # Pa, allowable for case-hardened steel of quality MQ, ISO 6336-5
WALL = 2.3  # see above


@dataclass(frozen=True, kw_only=True)
class SpalledTooth(FlankDamage):
    """A spall of a flank; the mating tooth rests on the edges of the spall.

    Parts beyond the flank are ignored.
    """

    length: float = option(
        unit="mm", gt=0, text="size of the spall along the face; the part beyond the end of the face is ignored"
    )
    depth: float = option(unit="um", gt=0, text="depth of the spall below the flank")
    shape: Literal["ellipse", "rectangle"] = option("ellipse", text="outline of the spall")

    def patches(self, gear: Gear) -> tuple[Patch, ...]:
        """The one patch on the flank of a gear."""
        spall = Patch(
            radius=gear.reference_radius if self.diameter is None else self.diameter / 2,
            face=self.position,
            height=self.height,
            length=self.length,
            depth=self.depth,
            shape=self.shape,
        )
        return (spall,)

    def check(self, gear: Gear) -> None:
        """Raises GeometryError for a spall that is not on the flank."""
        label = f"spalled tooth of gear z={gear.teeth}"
        self.patches(gear)[0].check(label, gear)

    def compliance(self, law: MeshLaw, pair: GearPair, gear: str) -> np.ndarray:
        """Compliance (slice, position), m2/N, that the rim adds; none to models without Hertz contact."""
        added = super().compliance(law, pair, gear)
        if self.flank != law.flank or law.contact_slope == 0.0:
            return added
        own, patch = getattr(pair, gear), self.patches(getattr(pair, gear))[0]
        parts = face_parts(law, pair, patch.ends)
        flank = path_points(pair, parts.xi.ravel(), 0.5 * pair.pinion.normal_module)
        arc = arc_at(own, flank.pinion_radius if gear == "pinion" else flank.wheel_radius).reshape(parts.xi.shape)
        radius = np.maximum(flank.relative_radius, 1e-3 * pair.base_pitch).reshape(parts.xi.shape)
        middle, half = arc_at(own, patch.radius), patch.half_height(parts.face)[:, None]
        below = np.where(middle > half, arc - (middle - half), np.inf)
        above = np.where(middle + half < arc_at(own, own.tip_form_radius), middle + half - arc, np.inf)
        inside = np.minimum(below, above)
        first, last = patch.ends
        bridged = (parts.face > first) & (parts.face < last)
        on_path = (flank.gap == 0.0).reshape(radius.shape)
        bridged = bridged[:, None] & on_path & (inside < np.sqrt(2 * radius * patch.depth))
        width = 2 * np.pi * law.contact_slope * USUAL_PRESSURE * radius
        softness = [1 / m.plane_strain_modulus for m in (pair.pinion_material, pair.wheel_material)]
        part = softness[gear == "wheel"] / sum(softness)
        edge = edge_compliance(inside / width, part, patch.depth / width)
        edge *= np.minimum((below + above) / (2 * width), 1.0)
        share = np.where(bridged, edge, 0.0) * (parts.width / law.slice_width[parts.slice])[:, None]
        np.add.at(added, parts.slice, law.contact_slope * share)
        return added

    def movement(self, pair: GearPair, approach: float, *, alone: bool) -> float:
        """Movement from the lost share of the contact line."""
        lost = lost_share(pair) * self.length / pair.face_width
        return approach * lost / (1 - lost)


def edge_compliance(inside: np.ndarray, part: float, depth: np.ndarray) -> np.ndarray:
    """Compliance of a rim in excess of that of a flank, divided by A; 0 where the Hertz contact is next to the rim.

    Parameters
    ----------
    inside : distance of the nominal contact from the rim, in half-widths b, inside the spall
    part : share of the spalled gear in 1 / E*
    depth : of the spall, in half-widths
    """
    place = np.maximum(inside, -1.0)
    kappa = (np.sqrt(place**2 + 3) - place) / 1.5
    edge = 1 - 0.75 * kappa**2 + 2 * np.log(2 / kappa) + 2 * np.minimum(place, 0.0) ** 2
    wall = (4 * np.pi**2 / (np.pi**2 - 4) - 2) * part * (1 - kappa**2 / 4) * np.log1p(WALL * depth / kappa)
    return np.asarray(edge + wall)
