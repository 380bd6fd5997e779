"""Materials: linear isotropic elasticity and density, in SI."""

from __future__ import annotations

import math
from dataclasses import dataclass


class MaterialError(ValueError):
    """A material constant is outside its physical range."""


@dataclass(frozen=True, kw_only=True)
class Material:
    """A linear isotropic material.

    elastic_modulus E (Pa), poisson_ratio nu (1), density rho (kg/m3).
    Raises MaterialError unless E > 0, -1 < nu < 0.5, rho > 0.
    """

    name: str
    elastic_modulus: float
    poisson_ratio: float
    density: float

    def __post_init__(self) -> None:
        for field in ("elastic_modulus", "density"):
            value = getattr(self, field)
            if not (math.isfinite(value) and value > 0.0):
                raise MaterialError(f"material {self.name!r}: {field} is {value!r}; give a finite value above 0 (SI)")
        if not -1.0 < self.poisson_ratio < 0.5:
            raise MaterialError(
                f"material {self.name!r}: poisson_ratio is {self.poisson_ratio!r}; give a value in (-1, 0.5)"
            )

    @property
    def plane_strain_modulus(self) -> float:
        """E / (1 - nu^2), Pa: what a line contact sees."""
        return self.elastic_modulus / (1.0 - self.poisson_ratio**2)

    @property
    def shear_modulus(self) -> float:
        """E / (2 (1 + nu)), Pa."""
        return self.elastic_modulus / (2.0 * (1.0 + self.poisson_ratio))


#: Steel with the constants of ISO 6336-1:2019 (E 206 GPa, nu 0.3); density of plain carbon steel.
STEEL = Material(name="steel", elastic_modulus=206e9, poisson_ratio=0.3, density=7850.0)

#: Grey cast iron EN-GJL-250; EN 1561:2011, table of physical properties (E 103 to 118 GPa, nu 0.26, 7.20 g/cm3).
CAST_IRON = Material(name="cast iron EN-GJL-250", elastic_modulus=110e9, poisson_ratio=0.26, density=7200.0)
