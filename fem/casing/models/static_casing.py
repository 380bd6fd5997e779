"""Casing model `static`: Guyan condensation to the bearing points; valid well below the first fixed-interface mode."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from threadpoolctl import threadpool_limits

from fem.casing.meshing.mesh import CasingMesh
from fem.casing.models.elastic_casing import ElasticCasing
from fem.casing.reduced.checkup import CheckUp, check_up
from fem.casing.reduced.modes import CasingModes, casing_modes
from fem.casing.reduced.reduction import reduce_body
from fem.elements.materials import Material


@dataclass(frozen=True, kw_only=True)
class StaticCasing(ElasticCasing):
    """Finite elements condensed statically to the bearing points; its inertia is right only far below resonance."""

    model: Literal["static"] = "static"

    def modes(self, mesh: CasingMesh, material: Material) -> tuple[CasingModes, CheckUp]:
        """Second stage: factorise and condense."""
        with threadpool_limits(1):  # the heavy steps run in two halves side by side
            casing = self.casing(mesh, material)
            reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, count=0, enrich=False)
            return casing_modes(casing, reduction, model=self.model, band_limit=0.0), check_up(casing, reduction)
