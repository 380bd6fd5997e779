"""Tables of one gear beyond its main data: rack, tip, thickness, body, and modifications of its flanks."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from pipelines.scene.tables.base import NotNegative, Number, Positive, Table
from pipelines.scene.tables.deviations import GearDeviationsTable

Shape = Annotated[Literal["linear", "parabolic"], Field(description="how the relief grows from its start")]
Micrometres = Annotated[Number, Field(ge=-1000, le=1000)]


class ReliefTable(Table):
    """Tip or root relief; give its start either as length_mm or as diameter_mm."""

    amount_um: Annotated[NotNegative, Field(le=1000, description="material removed at the end of the active profile")]
    length_mm: Annotated[Positive | None, Field(description="roll length from that end along the line of action")] = (
        None
    )
    diameter_mm: Annotated[Positive | None, Field(description="diameter where the relief starts")] = None
    shape: Shape = "linear"

    @model_validator(mode="after")
    def _one_start(self) -> ReliefTable:
        if (self.length_mm is None) == (self.diameter_mm is None):
            raise ValueError("give the start either as length_mm or as diameter_mm")
        return self


class EndReliefTable(Table):
    """Relief of one end of the face."""

    amount_um: Annotated[NotNegative, Field(le=1000, description="material removed at the end of the face")]
    length_mm: Annotated[Positive, Field(description="part of the face over which it fades out")]
    shape: Shape = "linear"


class GearTable(Table):
    """Details of the pinion or wheel of a stage; modifications stand on both flanks of every tooth."""

    rack_addendum: Annotated[Number | None, Field(gt=0.3, le=2, description="in modules; left out: the stage's")] = None
    rack_dedendum: Annotated[Number | None, Field(gt=0.3, le=2.5, description="in modules; left out: the stage's")] = (
        None
    )
    rack_tip_radius: Annotated[Number | None, Field(ge=0, le=1, description="in modules; left out: the stage's")] = None
    tip_alteration_mm: Annotated[Number, Field(description="k m_n, added to the tip radius; negative shortens")] = 0.0
    tip_chamfer_mm: Annotated[NotNegative, Field(description="radial height of the tip chamfer")] = 0.0
    tip_rounding_mm: Annotated[NotNegative, Field(description="radius of the tip edge rounding")] = 0.0
    thickness_allowance_um: Annotated[
        Micrometres, Field(description="tooth thickness allowance A_sn, normal section; negative gives backlash")
    ] = 0.0
    rim_thickness_mm: Annotated[Positive | None, Field(description="s_R below the root circle; left out: solid")] = None
    web_thickness_mm: Annotated[Positive | None, Field(description="b_s of the web below the rim")] = None
    web_offset_mm: Annotated[Number, Field(description="middle of the web from mid face, towards +y")] = 0.0
    tip_relief: Annotated[ReliefTable | None, Field(description="removes material towards the tip")] = None
    root_relief: Annotated[ReliefTable | None, Field(description="removes material towards the root")] = None
    profile_crowning_um: Annotated[Micrometres, Field(description="C_alpha at both ends of the active profile")] = 0.0
    lead_crowning_um: Annotated[Micrometres, Field(description="C_beta at both ends of the face")] = 0.0
    end_relief_minus_y: Annotated[EndReliefTable | None, Field(description="relief of the -y end of the face")] = None
    end_relief_plus_y: Annotated[EndReliefTable | None, Field(description="relief of the +y end of the face")] = None
    helix_slope_um: Annotated[
        Micrometres,
        Field(description="helix slope: removed at the +y end of the drive flank, added on the coast flank"),
    ] = 0.0
    deviations: GearDeviationsTable = GearDeviationsTable()


class MisalignmentTable(Table):
    """Misalignment of the axes over the face width, before any deflection."""

    in_plane_um: Annotated[Micrometres, Field(description="growth of the centre distance to +y, f_sigma_delta")] = 0.0
    out_of_plane_um: Annotated[
        Micrometres, Field(description="skew f_sigma_beta; positive opens the drive flanks at the +y end")
    ] = 0.0
