"""Tables of the gear pairs: stages with their mesh models, and deviations."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pipelines.scene.tables.base import Flag, Number, Positive, Table, Whole
from pipelines.scene.tables.gear_details import GearTable, MisalignmentTable


class IsoMesh(Table):
    """Mesh stiffness by ISO 6336-1: mean value by formula, shape by contact line length. Milliseconds."""

    model: Literal["iso"] = "iso"
    slices: Annotated[Whole, Field(ge=1, le=101, description="slices along the face")] = 15


class EnergyMesh(Table):
    """Mesh stiffness by the potential-energy method, for comparison with the literature. Milliseconds."""

    model: Literal["energy"] = "energy"
    slices: Annotated[Whole, Field(ge=1, le=101, description="slices along the face")] = 15
    positions: Annotated[Whole, Field(ge=16, le=1024, description="grid points of the tables per base pitch")] = 64


class PlaneMesh(Table):
    """Mesh stiffness by 2-D finite elements of the whole ring, sliced along the face. Seconds."""

    model: Literal["plane"] = "plane"
    slices: Annotated[Whole, Field(ge=1, le=101, description="slices along the face")] = 15
    refinement: Annotated[Number, Field(ge=0.5, le=8, description="divides all element sizes of the tooth sector")] = (
        1.0
    )
    positions: Annotated[Whole, Field(ge=16, le=1024, description="grid points of the tables per base pitch")] = 64


class SolidMesh(Table):
    """Mesh stiffness by 3-D finite elements of both whole wheels and contact along the face. Ten seconds."""

    model: Literal["solid"] = "solid"
    slices: Annotated[Whole, Field(ge=3, le=101, description="slices along the face")] = 31
    refinement: Annotated[Number, Field(ge=0.6, le=3, description="divides all element sizes")] = 1.0
    positions: Annotated[Whole, Field(ge=8, le=512, description="mesh positions per base pitch that are solved")] = 32


MeshModel = Annotated[IsoMesh | EnergyMesh | PlaneMesh | SolidMesh, Field(discriminator="model")]


class StageTable(Table):
    """One helical gear pair: the pinion drives, the wheel is driven."""

    pinion_shaft: Annotated[Whole | None, Field(ge=1, description="number of its shaft; left out in stage i: i")] = None
    wheel_shaft: Annotated[Whole | None, Field(ge=1, description="number of its shaft; left out in stage i: i + 1")] = (
        None
    )
    pinion_teeth: Annotated[Whole, Field(ge=8, le=400, description="z1")]
    wheel_teeth: Annotated[Whole, Field(ge=8, le=400, description="z2")]
    module_mm: Annotated[Number, Field(gt=0, le=60, description="normal module m_n")]
    pressure_angle_deg: Annotated[Number, Field(gt=5, lt=35, description="normal pressure angle alpha_n")] = 20.0
    helix_angle_deg: Annotated[Number, Field(ge=0, le=40, description="helix angle beta at the reference circle")] = 0.0
    pinion_hand: Annotated[Literal["right", "left"], Field(description="hand of the pinion's helix")] = "right"
    face_width_mm: Annotated[Number, Field(gt=0, le=2000, description="common face width b")]
    pinion_profile_shift: Annotated[Number, Field(ge=-1, le=1.5, description="x1")] = 0.0
    wheel_profile_shift: Annotated[Number, Field(ge=-1, le=1.5, description="x2")] = 0.0
    pinion_bore_mm: Annotated[
        Positive | None,
        Field(description="diameter where the gear body is bonded to the shaft; left out: half the root circle"),
    ] = None
    wheel_bore_mm: Annotated[
        Positive | None,
        Field(description="diameter where the gear body is bonded to the shaft; left out: half the root circle"),
    ] = None
    rack_addendum: Annotated[Number, Field(gt=0.5, le=1.6, description="in modules")] = 1.0
    rack_dedendum: Annotated[Number, Field(gt=0.8, le=2.0, description="in modules")] = 1.25
    rack_tip_radius: Annotated[Number, Field(gt=0, le=0.5, description="in modules")] = 0.38
    centre_distance_mm: Annotated[
        Positive | None,
        Field(description="working centre distance; left out: free of backlash by the profile shifts"),
    ] = None
    backlash_um: Annotated[
        Number | None,
        Field(
            ge=0,
            le=5000,
            description="transverse backlash along the line of action; left out: what centre distance and thickness "
            "allowances leave, 80 where neither is given",
        ),
    ] = None
    pinion: GearTable = GearTable()
    wheel: GearTable = GearTable()
    misalignment: MisalignmentTable = MisalignmentTable()
    position_mm: Annotated[Number, Field(description="mid face along the shafts (y)")] = 0.0
    direction_deg: Annotated[
        Number, Field(ge=-180, le=180, description="direction from pinion axis to wheel axis: 0 is +x, 90 is up")
    ] = 0.0
    cycle_at_start: Annotated[
        Number | None,
        Field(
            ge=0,
            lt=1,
            description="mesh cycle c at t = 0, modulo 1; left out: 0, or what another stage of one of its gears gives",
        ),
    ] = None
    mesh_damping_time_us: Annotated[Number, Field(ge=0, le=1000, description="tau_m: damping = tau_m * stiffness")] = (
        1.8
    )
    mesh: MeshModel = PlaneMesh()


class DeviationTable(Table):
    """Seeded deviations of every tooth within the tolerances of ISO 1328-1."""

    enabled: Annotated[Flag, Field(description="false: error-free gears")] = True
    iso_grade: Annotated[Whole, Field(ge=1, le=11, description="flank tolerance class of ISO 1328-1:2013")] = 5
    seed: Annotated[Whole, Field(ge=0, le=2**31, description="same seed, same deviations")] = 1
    include: Annotated[
        tuple[Literal["pitch", "profile", "helix"], ...],
        Field(description="which deviations: cumulative pitch, profile (slope and form), helix (slope and form)"),
    ] = ("pitch",)
