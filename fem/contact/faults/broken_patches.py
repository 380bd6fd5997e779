"""Patches broken out of a flank: the gap is that of the mate bridging the rim, not the depth.

Within a patch the mate is supported by the rim above and below it, so that the gap is at most that of the nearer rim,

    g(xi, y) = min(depth, gap of the lower rim, gap of the upper rim)        a rim at distance s: about s^2 / (2 rho)

with the radius rho of relative curvature. The largest gap of a patch of half height a is a^2 / (2 rho), for example 25
um for 2 a = 1 mm on a radius of 5 mm. A rim beyond the tip, or out of reach of the mate, gives no support; a tip edge
of the mate touches the floor. Height and gap of an elliptical patch decrease to zero at its ends. A rim has the
compliance of a flank; `fem.contact.faults.spalled_tooth` adds that of the rim of a spall, pits add none.
"""

from __future__ import annotations

import abc
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.contact.faults.gap_on_slices import FaceParts, gap_on_slices
from fem.contact.faults.tooth_fault import ToothFault
from fem.contact.law import MeshLaw
from fem.gears.gear import Gear
from fem.gears.gear_checks import require
from fem.gears.geometry import GearPair
from fem.gears.path import edge_gap, path_points
from fem.options import option

DEEPEST = 0.5  # modules
SHAPES = ("ellipse", "rectangle")


@dataclass(frozen=True, kw_only=True)
class FlankDamage(ToothFault):
    """Base of the faults on an area of a flank."""

    height: float = option(unit="mm", gt=0, text="size of the damage along the flank, from root to tip")
    diameter: float | None = option(
        None, unit="mm", gt=0, text="diameter at its centre; without it: the reference circle"
    )
    position: float = option(0.0, unit="mm", text="y of its centre from the middle of the face")
    flank: Literal["drive", "coast"] = option("drive", text="damaged flank of the tooth")

    @abc.abstractmethod
    def patches(self, gear: Gear) -> tuple[Patch, ...]:
        """The patches on the flank of a gear, the same for the same values."""

    def gap(self, law: MeshLaw, pair: GearPair, gear: str) -> np.ndarray:
        """Gap (slice, position), m, on the damaged flank."""
        if self.flank != law.flank:
            return super().gap(law, pair, gear)
        return patches_gap(law, pair, gear, self.patches(getattr(pair, gear)))


@dataclass(frozen=True, kw_only=True)
class Patch:
    """A patch around the point at `radius` of the flank and `face` from mid face.

    height along the flank, length along the face and depth, m

    shape : "ellipse", or "rectangle"
    """

    radius: float
    face: float
    height: float
    length: float
    depth: float
    shape: str = "ellipse"

    def check(self, label: str, gear: Gear) -> None:
        """Raises GeometryError for a patch that is not on the flank."""
        require(self.shape in SHAPES, f"{label}: shape is {self.shape!r}; choose one of {', '.join(SHAPES)}")
        limit = DEEPEST * gear.normal_module
        require(
            0.0 < self.depth <= limit,
            f"{label}: the depth of {1e6 * self.depth:.4g} um is more than {DEEPEST} modules. Set at most "
            f"{1e6 * limit:.4g} um",
        )
        lowest = max(gear.base_radius, gear.root_radius)
        require(
            lowest < self.radius <= gear.tip_radius,
            f"{label}: diameter_mm = {2000 * self.radius:.6g} is not on the flank. Set {2000 * lowest:.6g} to "
            f"{2000 * gear.tip_radius:.6g}",
        )
        height = arc_at(gear, gear.tip_radius) - arc_at(gear, lowest)
        require(
            0.0 < self.height <= height,
            f"{label}: height_mm = {1000 * self.height:.4g} is more than the height of the flank. Set at most "
            f"{1000 * height:.4g}",
        )
        require(
            0.0 < self.length <= gear.face_width * (1 + 1e-9),
            f"{label}: length_mm = {1000 * self.length:.4g} is more than the face width. Set at most "
            f"{1000 * gear.face_width:.4g}",
        )
        require(
            abs(self.face) <= gear.face_width / 2 * (1 + 1e-9),
            f"{label}: its centre is {1000 * abs(self.face):.4g} mm from the middle of the face and not on the flank. "
            "Set "
            f"position_mm between {-500 * gear.face_width:.4g} and {500 * gear.face_width:.4g}",
        )

    @property
    def ends(self) -> tuple[float, float]:
        """Face coordinates of its ends."""
        return self.face - self.length / 2, self.face + self.length / 2

    def half_height(self, face: np.ndarray) -> np.ndarray:
        """Half the height (m) of the patch at face coordinates inside it."""
        if self.shape == "rectangle":
            return np.full(np.shape(face), self.height / 2)
        part = 2.0 * (face - self.face) / self.length
        return self.height / 2 * np.sqrt(np.maximum(1.0 - part**2, 0.0))


def arc_at(gear: Gear, radius: np.ndarray | float) -> np.ndarray:
    """Length (m) along the involute from the base circle to a radius: (r^2 - r_b^2) / (2 r_b)."""
    return np.maximum(np.square(radius) - gear.base_radius**2, 0.0) / (2.0 * gear.base_radius)


def radius_at(gear: Gear, arc: np.ndarray) -> np.ndarray:
    """The radius (m) at lengths along the involute."""
    return np.sqrt(gear.base_radius**2 + 2.0 * gear.base_radius * np.maximum(arc, 0.0))


def patches_gap(law: MeshLaw, pair: GearPair, gear: str, patches: Sequence[Patch]) -> np.ndarray:
    """Gap (slice, position), m, of patches on the flank of the law; the larger gap where two overlap.

    Parameters
    ----------
    law, pair : of one flank, and its gears
    gear : gear with the patches, "pinion" or "wheel"
    patches : in the face coordinate of the law
    """
    ends = [end for patch in patches for end in patch.ends]

    def gap(parts: FaceParts) -> np.ndarray:
        flank = path_points(pair, parts.xi.ravel(), 0.5 * pair.pinion.normal_module, (math.inf, math.inf))
        radius = (flank.pinion_radius if gear == "pinion" else flank.wheel_radius).reshape(parts.xi.shape)
        before, found = flank.gap.reshape(parts.xi.shape), np.zeros_like(parts.xi)
        for patch in patches:
            first, last = patch.ends
            at = (parts.face > first) & (parts.face < last)
            if at.any():
                added = _patch_gap(pair, gear, patch, parts.face[at], parts.xi[at], radius[at], before[at])
                found[at] = np.maximum(found[at], added)
        return found

    return gap_on_slices(law, pair, ends, gap)


def _patch_gap(
    pair: GearPair,
    gear: str,
    patch: Patch,
    face: np.ndarray,
    xi: np.ndarray,
    radius: np.ndarray,
    before: np.ndarray,
) -> np.ndarray:
    """Gap (part, position), m, added by a patch in parts of the face (part,) inside it.

    Contact with the undamaged flank is at the `radius`, with the gap `before` for tip-edge contact.
    """
    own: Gear = getattr(pair, gear)
    middle, half = arc_at(own, patch.radius), patch.half_height(face)[:, None]
    low, high = radius_at(own, middle - half), radius_at(own, middle + half)
    total = before + patch.depth
    with np.errstate(invalid="ignore"):
        for rim, there in ((low, middle - half > 0.0), (high, high < own.tip_form_radius)):
            total = np.minimum(total, np.where(there, edge_gap(pair, gear, xi, rim), np.inf))
        added = np.where(np.isfinite(before), total - before, 0.0)
    inside = (radius > low) & ((radius < high) | (high >= own.tip_form_radius))
    return np.where(inside, np.maximum(added, 0.0), 0.0)
