"""Casing model `static`: Guyan condensation to the bearing points; valid well below the first fixed-interface mode."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from fem.casing.models.casing_model import Structure
from fem.casing.models.elastic_casing import ElasticCasing
from fem.casing.models.reduction_stages import CasingReduction

if TYPE_CHECKING:
    from fem.casing.reduced.casing_modes import CasingModes
    from fem.casing.reduced.grounded import AssembledCasing
    from fem.casing.reduced.reduction import Reduction


@dataclass(frozen=True, kw_only=True)
class StaticReduction(CasingReduction):
    """Static condensation to the bearing points; its inertia is accurate only far below resonance."""

    static: ClassVar[bool] = True

    def reduced(self, casing: AssembledCasing) -> tuple[CasingModes, Reduction]:
        """Constraint modes alone."""
        from fem.casing.reduced.casing_modes import casing_modes
        from fem.casing.reduced.halves import reduced_and_counted

        reduction, _ = reduced_and_counted(casing.subspaces, casing.loads, highest=None)
        return casing_modes(casing, reduction, model="static", band_limit=0.0), reduction


@dataclass(frozen=True, kw_only=True)
class StaticCasing(ElasticCasing):
    """Finite elements condensed statically (Guyan) to the bearing points."""

    model: Literal["static"] = "static"
    added_modes: ClassVar[int] = 40

    def reduction(self, structure: Structure) -> StaticReduction:
        """Static condensation."""
        return StaticReduction(held=self.held(structure), regions=self.regions(structure), forced=structure.forced)
