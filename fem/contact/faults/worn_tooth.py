"""Material worn off both flanks: a gap over the profile, the same along the face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.contact.faults.tooth_fault import ToothFault
from fem.contact.frame import law_points
from fem.contact.law import MeshLaw
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.gears.rack import require

DEEPEST = 0.2  # modules


@dataclass(frozen=True, kw_only=True)
class WornTooth(ToothFault):
    """Material worn off both flanks: `depth` (m, normal to the flank) at the worst place.

    place "flank": even over the whole flank. "pitch" (pitch point) or "root" (lower end of the active profile): a
    cosine bell that has fallen to nothing at the roll length `width` / 2 (m) to either side.
    """

    depth: float
    place: str = "flank"
    width: float | None = None

    def check(self, gear: Gear) -> None:
        """Raises GeometryError for wear that is none or eats the tooth up."""
        label = f"worn tooth of gear z={gear.teeth}"
        limit = DEEPEST * gear.normal_module
        require(
            0.0 < self.depth <= limit,
            f"{label}: depth is {self.depth:.4g} m; give a value in (0, {limit:.4g}] m, {DEEPEST} modules",
        )
        require(
            self.place in ("flank", "pitch", "root"),
            f"{label}: place is {self.place!r}; choose 'flank', 'pitch' or 'root'",
        )
        require(
            (self.width is None) == (self.place == "flank") and (self.width is None or self.width > 0.0),
            f"{label}: width is {self.width!r} m with place {self.place!r}; local wear needs a width > 0, even wear "
            "none",
        )

    def gap_at(self, roll: np.ndarray, pitch_roll: float, root_roll: float) -> np.ndarray:
        """Wear (m) at the roll lengths (position,); those of pitch point and root end are given."""
        if self.width is None:
            return np.full(np.shape(roll), self.depth)
        centre = pitch_roll if self.place == "pitch" else root_roll
        return self.depth * np.cos(np.clip(np.pi * (roll - centre) / self.width, -np.pi / 2, np.pi / 2)) ** 2

    def gap(self, law: MeshLaw, pair: GearPair, gear: str) -> np.ndarray:
        """Gap (position,), m."""
        points, side = law_points(law, pair), 0 if gear == "pinion" else 1
        own = getattr(pair, gear)
        radius = points.pinion_radius if gear == "pinion" else points.wheel_radius
        roll = np.sqrt(np.maximum(radius**2 - own.base_radius**2, 0.0))
        root = min(pair.roll_lengths(xi)[side] for xi in (pair.xi_start, pair.xi_end))
        return self.gap_at(roll, pair.roll_lengths(0.0)[side], root)

    def movement(self, pair: GearPair, approach: float, *, alone: bool) -> float:
        """Its depth; of one tooth no more than if that were missing."""
        missing = super().movement(pair, approach, alone=alone)
        assert missing is not None
        return min(self.depth, missing) if alone else self.depth
