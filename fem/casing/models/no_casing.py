"""Casing model `none`: bearings held by the ground; no casing motion, no sensors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from fem.casing.models.body_stages import BearingsOnGround
from fem.casing.models.casing import CasingModel, Structure
from fem.casing.models.stage import BODY, PlannedStage


@dataclass(frozen=True, kw_only=True)
class NoCasing(CasingModel):
    """Bearings held by the ground. The channels are bearing forces and shaft motions; there are no sensors."""

    model: Literal["none"] = "none"
    added_modes: ClassVar[int] = 0

    def stages(self, structure: Structure) -> tuple[PlannedStage, ...]:
        """The body alone."""
        return (PlannedStage(name=BODY, stage=BearingsOnGround(bearings=structure.bearings)),)
