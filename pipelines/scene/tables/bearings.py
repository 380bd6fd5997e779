"""Tables of the bearings: one table for all of them, or one per bearing of a shaft."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from pipelines.border.shown import shown_value
from pipelines.scene.tables.base import Number, Table, Whole


class RigidBearings(Table):
    """Bearings that hold all displacements and leave tilting free."""

    model: Literal["rigid"] = "rigid"


class LinearBearings(Table):
    """Linear springs and dampers between a shaft and its support."""

    model: Literal["linear"] = "linear"
    radial_stiffness_N_per_um: Annotated[
        Number, Field(ge=0.01, le=1e6, description="radial stiffness along x and z")
    ] = 100.0
    vertical_stiffness_N_per_um: Annotated[
        Number | None,
        Field(ge=0.01, le=1e6, description="radial stiffness along z, where it differs from that along x"),
    ] = None
    cross_stiffness_N_per_um: Annotated[
        Number, Field(ge=-1e6, le=1e6, description="symmetric coupling stiffness between x and z")
    ] = 0.0
    axial_stiffness_N_per_um: Annotated[Number, Field(ge=0.01, le=1e6, description="stiffness along the shaft")] = 50.0
    tilt_stiffness_N_m_per_rad: Annotated[
        Number, Field(ge=0, le=1e9, description="tilting stiffness about x and z")
    ] = 1.0e4
    damping_time_us: Annotated[
        Number, Field(ge=0, le=1e4, description="damping matrix divided by stiffness matrix")
    ] = 5.0


class HertzBearings(Table):
    """Rolling bearings: Hertz contact of every rolling element, clearance or preload, rotating cage."""

    model: Literal["hertz"] = "hertz"
    designation: Annotated[
        str | None,
        Field(
            description='bearing of the built-in catalogue, e.g. "6208"; without it give kind, elements, '
            "element_diameter_mm and pitch_diameter_mm"
        ),
    ] = None
    kind: Annotated[Literal["ball", "roller"] | None, Field(description="shape of the rolling elements")] = None
    elements: Annotated[Whole | None, Field(ge=3, le=100, description="number of rolling elements")] = None
    element_diameter_mm: Annotated[Number | None, Field(gt=0, description="diameter of a ball or roller")] = None
    pitch_diameter_mm: Annotated[
        Number | None, Field(gt=0, description="diameter of the circle through the centres of the elements")
    ] = None
    contact_angle_deg: Annotated[
        Number | None,
        Field(
            ge=-60, le=60, description="contact angle without load; positive: the bearing supports the shaft against +y"
        ),
    ] = None
    roller_length_mm: Annotated[Number | None, Field(gt=0, description="effective contact length of a roller")] = None
    inner_conformity: Annotated[
        Number | None, Field(gt=0.5, le=0.6, description="groove radius of the inner race over ball diameter")
    ] = None
    outer_conformity: Annotated[
        Number | None, Field(gt=0.5, le=0.6, description="groove radius of the outer race over ball diameter")
    ] = None
    radial_clearance_um: Annotated[
        Number, Field(ge=-100, le=1000, description="clearance on the diameter; negative: interference")
    ] = 0.0
    axial_preload_um: Annotated[
        Number,
        Field(
            ge=-1000, le=1000, description="axial displacement of the inner ring relative to the outer one at assembly"
        ),
    ] = 0.0
    damping_time_us: Annotated[Number, Field(ge=0, le=1e4, description="damping divided by tangent stiffness")] = 5.0
    cage_start_deg: Annotated[
        Number, Field(ge=-360, le=360, description="angle of the first rolling element at t = 0")
    ] = 0.0
    cage_slip: Annotated[
        Number,
        Field(
            ge=0,
            le=0.05,
            description="standard deviation of the cage slip as a share of the cage speed; a new "
            "random value from deviations.seed at every passage of an element; 0: no slip",
        ),
    ] = 0.0

    @model_validator(mode="after")
    def _described(self) -> HertzBearings:
        needed = ("kind", "elements", "element_diameter_mm", "pitch_diameter_mm")
        given = [key for key in needed if getattr(self, key) is not None]
        if self.designation is None and len(given) < len(needed):
            missing = ", ".join(key for key in needed if key not in given)
            raise ValueError(f"{missing}: missing. Set them, or designation for a bearing of the catalogue")
        if self.designation is not None and given:
            raise ValueError(
                f"designation = {shown_value(self.designation)} already determines {', '.join(given)}. Delete one or "
                "the other"
            )
        return self


BearingModel = Annotated[RigidBearings | LinearBearings | HertzBearings, Field(discriminator="model")]
