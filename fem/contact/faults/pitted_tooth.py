"""Pits: many small round patches on a flank, sampled with a seed.

Centres are uniformly distributed over the pitted area. Diameters are log-normal (few large pits among many small ones),
with given median and geometric standard deviation: an assumption, to be set by observation. Pits do not overlap. They
are sampled until they cover the given share of the area. Models of round pits around the pitch line by severity: Liang,
Zhang, Liu & Zuo (2016), Mech. Mach. Theory 106, 1-15; ISO 6336-2 takes 4 % of the flank of one hardened tooth as the
end of its life.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.contact.faults.broken_patches import DEEPEST, FlankDamage, Patch, arc_at, radius_at
from fem.contact.faults.tooth_fault import lost_share
from fem.gears.gear import Gear
from fem.gears.gear_checks import require
from fem.gears.geometry import GearPair
from fem.options import option

DENSEST = 0.3  # share of the area: limit for discs placed in sequence
MOST_PITS = 2000
_TRIES = 200  # for the position of one pit


@dataclass(frozen=True, kw_only=True)
class PittedTooth(FlankDamage):
    """Many round pits on an area of a flank, at random positions."""

    length: float | None = option(
        None, unit="mm", gt=0, text="size of the pitted area along the face; without it: whole face"
    )
    density: float = option(gt=0, le=DENSEST, text="share of the area that pits cover")
    pit: float = option(unit="mm", gt=0, text="median diameter of the pits")
    spread: float = option(1.4, ge=1, le=3, text="geometric standard deviation of the log-normal diameters")
    depth_part: float = option(0.25, gt=0, le=1, text="depth of a pit divided by its diameter")
    seed: int = option(1, ge=0, le=2**31, text="seed of the random places and diameters")

    def area(self, gear: Gear) -> Patch:
        """The pitted area as a patch; its depth is that of the median pit."""
        return Patch(
            radius=gear.reference_radius if self.diameter is None else self.diameter / 2,
            face=self.position,
            height=self.height,
            length=gear.face_width if self.length is None else self.length,
            depth=self.depth_part * self.pit,
            shape="rectangle",
        )

    def check(self, gear: Gear) -> None:
        """Raises GeometryError for an area that is not on the flank, or pits that it cannot hold."""
        label = f"pitted tooth of gear z={gear.teeth}"
        self.area(gear).check(label, gear)
        largest = min(self.area(gear).height, self.area(gear).length) / 2
        require(
            0.0 < self.pit <= largest,
            f"{label}: pit_mm = {1000 * self.pit:.4g} is more than half the pitted area. Set at most "
            f"{1000 * largest:.4g}, or raise height_mm or length_mm",
        )
        count = self.density * self.area(gear).height * self.area(gear).length / (math.pi / 4 * self.pit**2)
        require(
            count <= MOST_PITS,
            f"{label}: pit_mm = {1000 * self.pit:.4g} with density = {self.density:g} gives about {count:.0f} pits, "
            "more than "
            f"{MOST_PITS}. Raise pit_mm or reduce density",
        )

    def patches(self, gear: Gear) -> tuple[Patch, ...]:
        """All pits, the same for the same values.

        If the area cannot reach the density, sampling ends with the last pit that fits.
        """
        draw, area = np.random.default_rng(self.seed), self.area(gear)
        middle = float(arc_at(gear, area.radius))
        wanted = self.density * area.height * area.length
        found = np.zeros((0, 3))  # along the flank, along the face, diameter
        covered, deepest = 0.0, DEEPEST * gear.normal_module
        while covered < wanted:
            size = self.pit * self.spread ** float(draw.standard_normal())
            size = min(size, area.height, area.length, 2.0 * math.sqrt((wanted - covered) / math.pi))
            for _ in range(_TRIES):
                up = (area.height - size) * float(draw.uniform(-0.5, 0.5))
                along = area.face + (area.length - size) * float(draw.uniform(-0.5, 0.5))
                apart = np.hypot(found[:, 0] - up, found[:, 1] - along)
                if (apart > (found[:, 2] + size) / 2).all():
                    break
            else:
                break
            found = np.vstack([found, [up, along, size]])
            covered += math.pi / 4 * size**2 * (1 + 1e-12)
        return tuple(
            Patch(
                radius=float(radius_at(gear, np.array(middle + up))),
                face=float(along),
                height=float(size),
                length=float(size),
                depth=min(self.depth_part * float(size), deepest),
            )
            for up, along, size in found
        )

    def movement(self, pair: GearPair, approach: float, *, alone: bool) -> float:
        """Movement from the loss of the covered share of the contact line."""
        length = pair.face_width if self.length is None else self.length
        lost = lost_share(pair) * self.density * length / pair.face_width
        return approach * lost / (1 - lost)
