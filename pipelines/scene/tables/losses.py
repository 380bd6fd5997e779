"""Tables of the losses: what makes lowering differ from lifting."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pipelines.scene.tables.base import Number, Table


class NoLosses(Table):
    """Meshes and bearings without friction."""

    model: Literal["none"] = "none"


class EfficiencyLosses(Table):
    """Every mesh passes on the given share of the power that enters it."""

    model: Literal["efficiency"] = "efficiency"
    mesh_efficiency: Annotated[Number, Field(gt=0.5, le=1, description="power out over power in, of every mesh")] = 0.99


class CoulombLosses(Table):
    """Sliding friction of the teeth, reversing at the pitch point, and drag of the bearings."""

    model: Literal["coulomb"] = "coulomb"
    tooth_friction: Annotated[Number, Field(ge=0, le=0.5, description="friction over normal force of a tooth pair")] = (
        0.05
    )
    bearing_friction: Annotated[
        Number, Field(ge=0, le=0.1, description="drag over load, at half the shaft diameter in the bearing")
    ] = 0.0015


LossModel = Annotated[NoLosses | EfficiencyLosses | CoulombLosses, Field(discriminator="model")]
