"""Tables of one gear beyond its main data: rack, tip, thickness, body, and modifications of its flanks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from fem.gears.modifications import EndRelief, Relief
from pipelines.scene.tables.base import NotNegative, Number, Positive, Table
from pipelines.scene.tables.derived import table
from pipelines.scene.tables.deviations import GearDeviationsTable

Micrometres = Annotated[Number, Field(ge=-1000, le=1000)]


if TYPE_CHECKING:
    ReliefTable = Any
    EndReliefTable = Any
else:
    ReliefTable = table(Relief)
    EndReliefTable = table(EndRelief)


class GearTable(Table):
    """Details of the pinion or wheel of a stage. Modifications are on both flanks of every tooth."""

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
    tip_alteration_mm: Annotated[
        Number, Field(description="tip alteration k m_n of the tip radius; negative: shorter teeth")
    ] = 0.0
    tip_chamfer_mm: Annotated[NotNegative, Field(description="radial height of the tip chamfer")] = 0.0
    tip_rounding_mm: Annotated[NotNegative, Field(description="radius of the tip rounding")] = 0.0
    thickness_allowance_um: Annotated[
        Micrometres, Field(description="tooth thickness allowance A_sn in the normal section; negative: more backlash")
    ] = 0.0
    rim_thickness_mm: Annotated[
        Positive | None, Field(description="rim thickness s_R below the root circle; without it: solid gear body")
    ] = None
    web_thickness_mm: Annotated[Positive | None, Field(description="web thickness b_s below the rim")] = None
    web_offset_mm: Annotated[Number, Field(description="y of the middle of the web from the middle of the face")] = 0.0
    tip_relief: Annotated[ReliefTable | None, Field(description="tip relief")] = None
    root_relief: Annotated[ReliefTable | None, Field(description="root relief")] = None
    profile_crowning_um: Annotated[
        Micrometres, Field(description="profile crowning C_alpha, at both ends of the active profile")
    ] = 0.0
    lead_crowning_um: Annotated[Micrometres, Field(description="lead crowning C_beta, at both ends of the face")] = 0.0
    end_relief_minus_y: Annotated[EndReliefTable | None, Field(description="end relief at the -y end of the face")] = (
        None
    )
    end_relief_plus_y: Annotated[EndReliefTable | None, Field(description="end relief at the +y end of the face")] = (
        None
    )
    helix_slope_um: Annotated[
        Micrometres,
        Field(
            description="helix slope modification: material removed at the +y end of the drive flank, and added "
            "there on the coast flank"
        ),
    ] = 0.0
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
