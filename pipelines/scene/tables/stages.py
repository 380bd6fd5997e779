"""Tables of stages: a gear pair with its mesh model; and random deviations of all gears."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from fem.contact.models.mesh_model_registry import MODELS, mesh_model
from fem.contact.models.plane import Plane
from fem.gears.deviations import RandomDeviations
from pipelines.scene.tables.derived import DerivedTable, choice, table
from pipelines.scene.tables.gears import GearTable, MisalignmentTable
from pipelines.scene.tables.scene_table import Flag, Number, Positive, Table, Whole

MeshModel: TypeAlias = choice((table(mesh_model(name)) for name in MODELS), "model")


class StageTable(Table):
    """One pair of external spur or helical gears. The pinion drives, the wheel is driven."""

    pinion_shaft: Annotated[
        Whole | None, Field(ge=1, description="number of the shaft of the pinion; without it: i in stage i")
    ] = None
    wheel_shaft: Annotated[
        Whole | None, Field(ge=1, description="number of the shaft of the wheel; without it: i + 1 in stage i")
    ] = None
    pinion_teeth: Annotated[Whole, Field(ge=8, le=400, description="number of teeth z1")]
    wheel_teeth: Annotated[Whole, Field(ge=8, le=400, description="number of teeth z2")]
    module_mm: Annotated[Number, Field(ge=0.05, le=60, description="normal module m_n")]
    pressure_angle_deg: Annotated[Number, Field(gt=5, lt=35, description="normal pressure angle alpha_n")] = 20.0
    helix_angle_deg: Annotated[Number, Field(ge=0, le=40, description="helix angle beta at the reference circle")] = 0.0
    pinion_hand: Annotated[Literal["right", "left"], Field(description="hand of the helix of the pinion")] = "right"
    face_width_mm: Annotated[Number, Field(gt=0, le=2000, description="common face width b")]
    pinion_profile_shift: Annotated[Number, Field(ge=-1, le=1.5, description="profile shift coefficient x1")] = 0.0
    wheel_profile_shift: Annotated[Number, Field(ge=-1, le=1.5, description="profile shift coefficient x2")] = 0.0
    pinion_bore_mm: Annotated[
        Positive | None,
        Field(description="diameter on which the pinion is bonded to its shaft; without it: half the root diameter"),
    ] = None
    wheel_bore_mm: Annotated[
        Positive | None,
        Field(description="diameter on which the wheel is bonded to its shaft; without it: half the root diameter"),
    ] = None
    rack_addendum: Annotated[
        Number, Field(gt=0.5, le=1.6, description="addendum of the basic rack divided by module")
    ] = 1.0
    rack_dedendum: Annotated[
        Number, Field(gt=0.8, le=2.0, description="dedendum of the basic rack divided by module")
    ] = 1.25
    rack_tip_radius: Annotated[
        Number,
        Field(gt=0, le=0.5, description="tip radius of the basic rack divided by module, which forms the root fillet"),
    ] = 0.38
    centre_distance_mm: Annotated[
        Positive | None,
        Field(
            description="working centre distance; without it: the distance without backlash that the "
            "profile shifts give"
        ),
    ] = None
    backlash_um: Annotated[
        Number | None,
        Field(
            ge=0,
            le=5000,
            description="transverse backlash along the line of action; without it: the backlash from "
            "centre distance and thickness allowances, or 80 um if neither is given",
        ),
    ] = None
    pinion: Annotated[
        GearTable, Field(description="details of the pinion: basic rack, tip, body, modifications, deviations")
    ] = GearTable()
    wheel: Annotated[GearTable, Field(description="details of the wheel: the same keys")] = GearTable()
    misalignment: Annotated[MisalignmentTable, Field(description="misalignment of the two axes")] = MisalignmentTable()
    position_mm: Annotated[Number, Field(description="y of the middle of the face")] = 0.0
    direction_deg: Annotated[
        Number,
        Field(
            ge=-180, le=180, description="direction from the axis of the pinion to that of the wheel: 0 is +x, 90 is up"
        ),
    ] = 0.0
    cycle_at_start: Annotated[
        Number | None,
        Field(
            ge=0,
            lt=1,
            description="position c in the mesh cycle at t = 0, in base pitches; without it: 0, or "
            "the position that follows from another stage with one of its gears",
        ),
    ] = None
    mesh_damping_time_us: Annotated[
        Number, Field(ge=0, le=1000, description="tau_m: damping of the mesh divided by its stiffness")
    ] = 1.8
    mesh: Annotated[MeshModel, Field(description="model of the mesh stiffness")] = table(Plane)()


class _DeviationBase(DerivedTable):
    """Whether gears deviate."""

    enabled: Annotated[
        Flag, Field(description="false: gears without any deviation, also without those of stages.pinion.deviations")
    ] = True


DeviationTable: TypeAlias = table(RandomDeviations, _DeviationBase)
