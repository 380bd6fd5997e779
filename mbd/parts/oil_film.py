"""Parameters of the oil film between the flanks of a gear pair, see `mbd.forces.film`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from fem.options import option
from mbd.parts.part_checks import Options


@dataclass(frozen=True, kw_only=True)
class Film(Options):
    """Squeeze film of oil between approaching flanks, in all meshes.

    ``radius`` (m) is that of relative curvature at the pitch point, ``length`` (m) the total length of the contact
    lines. The ``roughness`` (m) is the least thickness of the film.
    """

    model: Literal["squeeze"] = "squeeze"
    viscosity: float = option(0.05, unit="mPa s", gt=0, le=1e5, text="dynamic viscosity at the temperature of the oil")
    roughness: float = option(1e-6, unit="um", ge=0.05, le=100, text="least film thickness")
    radius: float
    length: float

    @property
    def strength(self) -> float:
        """12 pi eta b (R/2)^1.5 (N s m^0.5); the damping coefficient is this times h^-1.5."""
        return 12.0 * math.pi * self.viscosity * self.length * (0.5 * self.radius) ** 1.5
