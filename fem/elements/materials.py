"""Materials: linear isotropic elasticity and density, in SI."""

from __future__ import annotations

from dataclasses import dataclass

from fem.options import check_options, option


class MaterialError(ValueError):
    """A material constant is outside its physical range."""


@dataclass(frozen=True, kw_only=True)
class Material:
    """An isotropic linear elastic material.

    elastic_modulus E (Pa), poisson_ratio nu (1), density rho (kg/m3). MaterialError for one outside its range.
    """

    name: str
    elastic_modulus: float = option(text="Young's modulus; steel: 206", unit="GPa", ge=1e-3, le=1e6)
    poisson_ratio: float = option(text="Poisson's ratio", ge=0, lt=0.5)
    density: float = option(text="density; steel: 7850", unit="kg/m3", key="density_kg_m3", ge=1, le=1e5)

    def __post_init__(self) -> None:
        check_options(self, MaterialError)

    @property
    def plane_strain_modulus(self) -> float:
        """E / (1 - nu^2), Pa: modulus of a line contact."""
        return self.elastic_modulus / (1.0 - self.poisson_ratio**2)

    @property
    def shear_modulus(self) -> float:
        """E / (2 (1 + nu)), Pa."""
        return self.elastic_modulus / (2.0 * (1.0 + self.poisson_ratio))


#: Steel with the constants of ISO 6336-1:2019 (E 206 GPa, nu 0.3); density of plain carbon steel.
STEEL = Material(name="steel", elastic_modulus=206e9, poisson_ratio=0.3, density=7850.0)

#: Grey cast iron EN-GJL-250; EN 1561:2011, table of physical properties (E 103 to 118 GPa, nu 0.26, 7.20 g/cm3).
CAST_IRON = Material(name="cast iron EN-GJL-250", elastic_modulus=110e9, poisson_ratio=0.26, density=7200.0)
