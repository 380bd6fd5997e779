"""A spall: one patch broken out of a flank, see `fem.contact.faults.broken_patches`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from fem.contact.faults.broken_patches import FlankDamage, Patch
from fem.contact.faults.tooth_fault import lost_share
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.options import option


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

    def movement(self, pair: GearPair, approach: float, *, alone: bool) -> float:
        """Movement from the lost share of the contact line."""
        lost = lost_share(pair) * self.length / pair.face_width
        return approach * lost / (1 - lost)
