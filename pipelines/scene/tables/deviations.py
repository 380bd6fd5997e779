"""Tables of the deviations of one gear that are stated one by one; positive where there is more material."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from pipelines.scene.tables.base import NotNegative, Number, Table, Whole

Flank = Annotated[Literal["drive", "coast"], Field(description="flank of the tooth")]
Deviation = Annotated[Number, Field(ge=-1000, le=1000)]


class WaveTable(Table):
    """Waviness of the flanks along the circumference: ghost orders."""

    order: Annotated[Whole, Field(ge=1, le=100_000, description="number of waves around the circumference")]
    amplitude_um: Annotated[NotNegative, Field(le=1000, description="half the height from trough to crest")]
    phase_deg: Annotated[
        Number,
        Field(ge=-360, le=360, description="phase of the waves where tooth 0 touches at the pitch point; 0: a crest"),
    ] = 0.0
    flank: Annotated[Literal["drive", "coast", "both"], Field(description="flanks that have the waves")] = "both"


class ToothErrorTable(Table):
    """Deviations of one flank of one tooth."""

    tooth: Annotated[
        Whole, Field(ge=0, description="number of the tooth; tooth 0 touches at the pitch point at mesh cycle c = 0")
    ]
    flank: Flank = "drive"
    pitch_um: Annotated[
        Deviation, Field(description="pitch deviation along the reference circle; positive: more material")
    ] = 0.0
    profile_slope_um: Annotated[
        Deviation,
        Field(
            description="profile slope deviation f_Halpha over the active profile; positive: more material "
            "towards the tip"
        ),
    ] = 0.0


class MeasuredFlanksTable(Table):
    """Deviations at points of the flanks, as from a gear measuring machine: see docs/flank-deviations.md."""

    file: Annotated[
        str, Field(min_length=1, description="CSV or netCDF file: name in the folder of the scene, or a path")
    ]


class GearDeviationsTable(Table):
    """Given deviations of a gear, added to those of deviations.seed; none with deviations.enabled = false."""

    eccentricity_um: Annotated[
        NotNegative, Field(le=5000, description="eccentricity of the teeth from the axis of rotation, half the run-out")
    ] = 0.0
    eccentricity_angle_deg: Annotated[
        Number,
        Field(
            ge=-360,
            le=360,
            description="angle from tooth 0 to the eccentricity, positive in the sense of rotation of the gear",
        ),
    ] = 0.0
    waves: Annotated[tuple[WaveTable, ...], Field(max_length=100, description="waviness")] = ()
    teeth: Annotated[tuple[ToothErrorTable, ...], Field(max_length=1000, description="deviations of single teeth")] = ()
    flanks: Annotated[MeasuredFlanksTable | None, Field(description="measured flanks")] = None

    @model_validator(mode="after")
    def _each_tooth_once(self) -> GearDeviationsTable:
        named = [(error.tooth, error.flank) for error in self.teeth]
        for tooth, flank in named:
            if named.count((tooth, flank)) > 1:
                raise ValueError(f"teeth: tooth {tooth} has two entries for its {flank} flank. Delete one")
        return self

    @property
    def none(self) -> bool:
        """True when nothing is stated."""
        return self == GearDeviationsTable()
