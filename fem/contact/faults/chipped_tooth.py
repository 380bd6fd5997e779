"""A piece broken off a tooth: in its slices contact continues as tip-edge contact of the shortened tooth.

The extent along the face is rounded to whole slices, with an error of at most half a slice.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.contact.faults.tooth_fault import END, ToothFault, from_end, lost_share
from fem.contact.law import MeshLaw
from fem.gears.gear import Gear
from fem.gears.gear_checks import require
from fem.gears.geometry import GearPair
from fem.gears.path import path_points
from fem.options import option


@dataclass(frozen=True, kw_only=True)
class ChippedTooth(ToothFault):
    """A piece is broken off a tooth at the tip, from one end of the face."""

    extent: float = option(unit="mm", gt=0, text="length of the piece along the face")
    depth: float = option(unit="mm", gt=0, text="height of the piece below the tip circle")
    corner: bool = option(False, text="true: a corner of the tip; the depth falls to zero over extent_mm")
    end: Literal["-y", "+y"] = option("+y", text=END)

    def check(self, gear: Gear) -> None:
        """Raises GeometryError for a chip that does not fit on the tooth."""
        label = f"chipped tooth of gear z={gear.teeth}"
        require(
            0.0 < self.extent <= gear.face_width,
            f"{label}: extent_mm = {1000 * self.extent:.4g} is more than the face width. Set at most "
            f"{1000 * gear.face_width:.4g}",
        )
        height = gear.tip_radius - gear.root_radius
        require(
            0.0 < self.depth <= height * (1 + 1e-9),
            f"{label}: depth_mm = {1000 * self.depth:.4g} is more than the tooth height. Set at most "
            f"{1000 * height:.4g}",
        )

    def depth_at(self, face: np.ndarray, face_width: float) -> np.ndarray:
        """Depth (m) of the chip below the tip circle at the face coordinates (slice,)."""
        inwards = from_end(face, face_width, self.end)
        if self.corner:
            return self.depth * np.clip(1.0 - inwards / self.extent, 0.0, None)
        return np.where(inwards < self.extent, self.depth, 0.0)

    def gap(self, law: MeshLaw, pair: GearPair, gear: str) -> np.ndarray:
        """Gap (slice, position), m: 0 on the remaining flank, inf where no contact is possible."""
        own = getattr(pair, gear)
        xi = law.position_start + law.position_step * np.arange(law.compliance.size)
        largest = 0.5 * pair.pinion.normal_module
        sound = path_points(pair, xi, largest, (np.inf, np.inf)).gap
        depths = self.depth_at(law.face_coordinate, pair.face_width)
        added = np.zeros((depths.size, xi.size))
        for depth in np.unique(depths[depths > 0.0]):
            left = own.tip_radius - depth
            tips = (left, np.inf) if gear == "pinion" else (np.inf, left)
            short = path_points(pair, xi, largest, tips).gap
            with np.errstate(invalid="ignore"):
                more = np.where(np.isfinite(sound), short - sound, 0.0)
            added[depths == depth] = np.maximum(more, 0.0)
        return added

    def movement(self, pair: GearPair, approach: float, *, alone: bool) -> float:
        """Movement from the lost share of the contact line, as if the chip were as deep as the tooth."""
        lost = lost_share(pair) * self.extent / pair.face_width
        return approach * lost / (1 - lost)
