"""A spall: one patch broken out of a flank, see `fem.contact.faults.patches`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.contact.faults.patches import FlankDamage, Patch, patches_gap
from fem.contact.faults.tooth_fault import lost_share
from fem.contact.law import MeshLaw
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.options import option


@dataclass(frozen=True, kw_only=True)
class SpalledTooth(FlankDamage):
    """A spall of a flank; the mating tooth bridges it on its edge.

    Parts beyond the flank are ignored.
    """

    length: float = option(
        unit="mm", gt=0, text="size of the spall along the face; what is beyond the end of the face is left out"
    )
    depth: float = option(unit="um", gt=0, text="depth of the spall below the flank")
    shape: Literal["ellipse", "rectangle"] = option("ellipse", text="outline of the spall")

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
        self.patch(gear).check(label, gear)

    def gap(self, law: MeshLaw, pair: GearPair, gear: str) -> np.ndarray:
        """Gap (slice, position), m, on the flank of the spall."""
        if self.flank != law.flank:
            return super().gap(law, pair, gear)
        return patches_gap(law, pair, gear, [self.patch(getattr(pair, gear))])

    def movement(self, pair: GearPair, approach: float, *, alone: bool) -> float:
        """Movement from the lost share of the contact line."""
        lost = lost_share(pair) * self.length / pair.face_width
        return approach * lost / (1 - lost)
