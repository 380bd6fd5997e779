"""Tables of the shafts and their bearings."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from pipelines.tables.base import Number, Table


class SectionTable(Table):
    """A stretch of a shaft with constant diameters."""

    start_mm: Annotated[Number, Field(description="y of its -y end")]
    end_mm: Annotated[Number, Field(description="y of its +y end")]
    diameter_mm: Annotated[Number, Field(gt=0, description="outer diameter")]
    bore_mm: Annotated[Number, Field(ge=0, description="inner diameter")] = 0.0

    @model_validator(mode="after")
    def _ordered(self) -> SectionTable:
        if self.end_mm <= self.start_mm:
            raise ValueError(f"end_mm = {self.end_mm} must be greater than start_mm = {self.start_mm}")
        if self.bore_mm >= self.diameter_mm:
            raise ValueError(f"bore_mm = {self.bore_mm} must be smaller than diameter_mm = {self.diameter_mm}")
        return self


class ShaftTable(Table):
    """One shaft; shaft 1 is the input."""

    sections: Annotated[tuple[SectionTable, ...], Field(min_length=1, description="from -y to +y, without gaps")]
    bearing_positions_mm: Annotated[tuple[Number, Number], Field(description="y of its two bearings, -y first")]

    @model_validator(mode="after")
    def _joined(self) -> ShaftTable:
        for left, right in zip(self.sections, self.sections[1:], strict=False):
            if left.end_mm != right.start_mm:
                raise ValueError(f"sections: one ends at {left.end_mm} mm, the next starts at {right.start_mm} mm")
        first, last = self.bearing_positions_mm
        if not self.sections[0].start_mm <= first < last <= self.sections[-1].end_mm:
            raise ValueError(
                f"bearing_positions_mm = {[first, last]} must rise and lie between {self.sections[0].start_mm} and "
                f"{self.sections[-1].end_mm} mm"
            )
        return self


class ShaftModel(Table):
    """How shafts are modelled."""

    model: Annotated[
        Literal["torsion", "timoshenko"], Field(description="torsion: rigid but in twist; timoshenko: beam elements")
    ] = "timoshenko"
    element_length_mm: Annotated[Number, Field(gt=0, description="longest beam element")] = 40.0
    damping_time_us: Annotated[Number, Field(ge=0, le=1000, description="material damping = this time * stiffness")] = (
        0.5
    )


class BearingTable(Table):
    """Linear bearings between shaft and casing, the same for all."""

    model: Literal["linear"] = "linear"
    radial_stiffness_N_per_um: Annotated[Number, Field(ge=0.01, le=1e6, description="in x and z")] = 100.0
    axial_stiffness_N_per_um: Annotated[Number, Field(ge=0.01, le=1e6, description="along the shaft")] = 50.0
    tilt_stiffness_N_m_per_rad: Annotated[Number, Field(ge=0, le=1e9, description="about x and z")] = 1.0e4
    damping_time_us: Annotated[Number, Field(ge=0, le=1e4, description="damping = this time * stiffness")] = 5.0
