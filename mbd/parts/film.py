"""Oil film between the flanks of a gear pair: what `mbd.forces.film` needs to know."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mbd.parts.checks import positive


@dataclass(frozen=True, kw_only=True)
class Film:
    """Dynamic ``viscosity`` (Pa s), ``roughness`` (m) below which no film gets thinner, ``radius`` (m) of the cylinder
    that stands for both flanks at the pitch point, ``length`` (m) of the contact lines together."""

    viscosity: float
    roughness: float
    radius: float
    length: float

    def __post_init__(self) -> None:
        for name in ("viscosity", "roughness", "radius", "length"):
            positive(f"film {name}", getattr(self, name))

    @property
    def strength(self) -> float:
        """12 pi eta b (R/2)^1.5 (N s/m sqrt(m)^3): the damper is this times h^-1.5."""
        return 12.0 * math.pi * self.viscosity * self.length * (0.5 * self.radius) ** 1.5
