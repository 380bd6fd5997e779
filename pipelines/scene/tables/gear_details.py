"""Tables of one gear beyond its main data: rack, tip, thickness, body, and modifications of its flanks."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from fem.gears.gear import GearDetails
from fem.gears.modifications import FlankModifications
from pipelines.scene.tables.base import Number, Table
from pipelines.scene.tables.derived import DerivedTable, table
from pipelines.scene.tables.deviations import GearDeviationsTable

Micrometres = Annotated[Number, Field(ge=-1000, le=1000)]


class _RackBase(DerivedTable):
    """The basic rack of one gear."""

    rack_addendum: Annotated[
        Number | None,
        Field(gt=0.3, le=2, description="addendum of the basic rack over module; without it: that of the stage"),
    ] = None
    rack_dedendum: Annotated[
        Number | None,
        Field(gt=0.3, le=2.5, description="dedendum of the basic rack over module; without it: that of the stage"),
    ] = None
    rack_tip_radius: Annotated[
        Number | None,
        Field(
            ge=0,
            le=1,
            description="tip radius of the basic rack over module, which forms the root fillet; without it: that "
            "of the stage",
        ),
    ] = None


_Gear: Any = table(FlankModifications, table(GearDetails, _RackBase))


class GearTable(_Gear):
    """Details of the pinion or wheel of a stage. Modifications are on both flanks of every tooth."""

    deviations: Annotated[GearDeviationsTable, Field(description="deviations that are given instead of sampled")] = (
        GearDeviationsTable()
    )


class MisalignmentTable(Table):
    """Misalignment of the axes over the face width, without load."""

    in_plane_um: Annotated[
        Micrometres, Field(description="in-plane deviation f_sigma_delta: growth of the centre distance towards +y")
    ] = 0.0
    out_of_plane_um: Annotated[
        Micrometres,
        Field(description="out-of-plane deviation f_sigma_beta; positive opens the drive flanks at the +y end"),
    ] = 0.0
