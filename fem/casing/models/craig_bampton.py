"""Casing model `craig-bampton`: every mode to 1.5 times the wanted band, with inertia correction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from threadpoolctl import threadpool_limits

from fem.casing.meshing.mesh import CasingMesh
from fem.casing.models.elastic_casing import ElasticCasing
from fem.casing.reduced.body import MODES_OVER_BAND
from fem.casing.reduced.checkup import CheckUp, check_up
from fem.casing.reduced.halves import reduced_and_counted
from fem.casing.reduced.modes import CasingModes, casing_modes
from fem.elements.materials import Material


@dataclass(frozen=True, kw_only=True)
class CraigBamptonCasing(ElasticCasing):
    """Finite elements reduced to the bearing points and every fixed-interface mode to 1.5 times `band`."""

    model: Literal["craig-bampton"] = "craig-bampton"
    band: float = 5000.0  # Hz
    inertia_correction: bool = True

    @property
    def limit(self) -> float:
        """Frequency (Hz) up to which modes are kept."""
        return MODES_OVER_BAND * self.band

    def modes(self, mesh: CasingMesh, material: Material) -> tuple[CasingModes, CheckUp]:
        """Second stage: factorise and reduce.

        Raises
        ------
        EigenError : the modes found are not as many as the law of inertia counts
        """
        with threadpool_limits(1):  # the heavy steps run in two halves side by side
            casing = self.casing(mesh, material)
            reduction, counted = reduced_and_counted(
                casing.interface,
                lambda: (casing.K_free, casing.M_free),
                highest=self.limit,
                enrich=self.inertia_correction,
            )
            result = casing_modes(casing, reduction, model=self.model, band_limit=self.limit, counted=counted)
            return result, check_up(casing, reduction)
