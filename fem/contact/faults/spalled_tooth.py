"""A spall: one patch broken out of a flank, see `fem.contact.faults.patches`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.contact.faults.patches import Patch, patches_gap
from fem.contact.faults.tooth_fault import ToothFault, lost_share
from fem.contact.law import MeshLaw
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.gears.rack import require


@dataclass(frozen=True, kw_only=True)
class SpalledTooth(ToothFault):
    """A spall of `height` along the flank, `length` along the face and `depth` (m), cut off where it leaves the flank.

    diameter : of its middle (m), None: the reference circle
    position : of its middle from mid face (m)
    shape : "ellipse" or "rectangle"
    flank : "drive" or "coast"
    """

    height: float
    length: float
    depth: float
    diameter: float | None = None
    position: float = 0.0
    shape: str = "ellipse"
    flank: str = "drive"

    def patch(self, gear: Gear) -> Patch:
        """The patch on the flank of a gear."""
        return Patch(
            radius=gear.reference_radius if self.diameter is None else self.diameter / 2,
            face=self.position,
            height=self.height,
            length=self.length,
            depth=self.depth,
            shape=self.shape,
        )

    def check(self, gear: Gear) -> None:
        """Raises GeometryError for a spall that is not on the flank."""
        label = f"spalled tooth of gear z={gear.teeth}"
        require(self.flank in ("drive", "coast"), f"{label}: flank is {self.flank!r}; choose 'drive' or 'coast'")
        self.patch(gear).check(label, gear)

    def gap(self, law: MeshLaw, pair: GearPair, gear: str) -> np.ndarray:
        """Gap (slice, position), m, on the flank of the spall."""
        if self.flank != law.flank:
            return super().gap(law, pair, gear)
        return patches_gap(law, pair, gear, [self.patch(getattr(pair, gear))])

    def movement(self, pair: GearPair, approach: float, *, alone: bool) -> float:
        """Its part of the contact line is lost."""
        lost = lost_share(pair) * self.length / pair.face_width
        return approach * lost / (1 - lost)
