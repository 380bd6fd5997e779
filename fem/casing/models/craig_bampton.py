"""Casing model `craig-bampton`: fixed-interface modes up to 1.5 times the band, with inertia correction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Literal

from fem.casing.models.body_stages import Recovery
from fem.casing.models.casing_model import Structure
from fem.casing.models.elastic_casing import ElasticCasing
from fem.casing.models.reduction_stages import CasingReduction
from fem.casing.parts.casing_choices import MODES_OVER_BAND
from fem.options import option

if TYPE_CHECKING:
    from fem.casing.mesh.sizes import Sizes
    from fem.casing.reduced.casing_modes import CasingModes
    from fem.casing.reduced.grounded import AssembledCasing
    from fem.casing.reduced.reduction import Reduction


@dataclass(frozen=True, kw_only=True)
class CraigBamptonReduction(CasingReduction):
    """Constraint modes and all fixed-interface modes up to 1.5 times `band` (Hz). It also serves a lower band."""

    enough: ClassVar[str] = "band"
    static: ClassVar[bool] = False
    band: float

    def reduced(self, casing: AssembledCasing) -> tuple[CasingModes, Reduction]:
        """All modes below the limit, their number verified by a Sturm-sequence count."""
        from fem.casing.reduced.casing_modes import casing_modes
        from fem.casing.reduced.halves import reduced_and_counted

        limit = MODES_OVER_BAND * self.band
        reduction, counted = reduced_and_counted(casing.subspaces, casing.loads, highest=limit)
        return casing_modes(casing, reduction, model="craig-bampton", band_limit=limit, counted=counted), reduction


@dataclass(frozen=True, kw_only=True)
class CraigBamptonCasing(ElasticCasing):
    """Finite elements reduced to the bearing points and the fixed-interface modes (Craig-Bampton)."""

    model: Literal["craig-bampton"] = "craig-bampton"
    added_modes: ClassVar[int] = 280
    band: float = option(
        5000.0,
        unit="Hz",
        gt=0,
        le=20000,
        text="highest frequency of interest; modes up to 1.5 times this frequency are kept",
    )
    frequency_error: float | None = option(
        None,
        gt=0,
        lt=0.1,
        text="modes are omitted as long as no frequency in the band changes by more than this share; "
        "without it: all are kept",
    )
    elements_per_wavelength: float | None = option(
        None,
        gt=0,
        text="least elements per bending wavelength of the thinnest wall at band_Hz; reduces the element size where "
        "needed",
    )

    @property
    def limit(self) -> float:
        """Frequency (Hz) up to which modes are kept."""
        return MODES_OVER_BAND * self.band

    def sizes(self, structure: Structure) -> Sizes:
        """Edge lengths of the elements, at most a share of the bending wavelength of the thinnest wall."""
        from fem.casing.mesh.sizes import bending_wavelength

        given = super().sizes(structure)
        if self.elements_per_wavelength is None:
            return given
        assert structure.wall is not None, "the wavelength depends on it"
        assert structure.material is not None, "the wavelength depends on it"
        length = bending_wavelength(structure.material, structure.wall, self.band) / self.elements_per_wavelength
        return replace(given, element=min(given.element, length))

    def reduction(self, structure: Structure) -> CraigBamptonReduction:
        """All modes below the limit."""
        return CraigBamptonReduction(
            held=self.held(structure), regions=self.regions(structure), forced=structure.forced, band=self.band
        )

    def recovery(self, structure: Structure) -> Recovery:
        """The stage that adds damping, mounts and sensors, and selects the modes."""
        return replace(super().recovery(structure), frequency_error=self.frequency_error)
