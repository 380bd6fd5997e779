"""Tables of what moves the machine: drive, load, and the time integration."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from mbd.integrators.settings import MotionSettings
from pipelines.scene.tables.base import Number, Table, Whole
from pipelines.scene.tables.derived import table
from pipelines.scene.tables.samples import ColumnTable, Samples, check_pairs
from pipelines.scene.tables.torques import ControlledTable, InductionTable, SomewhereTable, TorqueCurve

Motors = Annotated[Literal[1, 2], Field(description="2: one motor at each end of the shaft; 1: one motor")]


class SpeedDrive(Table):
    """Motors of prescribed speed at the ends of a shaft, through couplings that transmit torque only."""

    model: Literal["speed"] = "speed"
    times_s: Annotated[Samples, Field(description="times, strictly rising, starting at 0; two or more")]
    speeds_rpm: Annotated[
        Samples,
        Field(
            description="motor speed at these times, linear in between; speeds from a file are joined by a smooth curve"
        ),
    ]
    motors: Motors = 2
    coupling_stiffness_N_m_per_rad: Annotated[
        Number, Field(gt=0, description="torsional stiffness of each coupling")
    ] = 2000.0
    coupling_damping_N_m_s_per_rad: Annotated[Number, Field(ge=0, description="torsional damping of each coupling")] = (
        0.5
    )
    shaft: Annotated[Whole | None, Field(ge=1, description="number of the driven shaft; without it: 1")] = None
    brake_torque_N_m: Annotated[
        Number,
        Field(
            ge=0,
            description="torque of a holding brake on that shaft at the first motor, which is closed "
            "while the motors stand still; 0: no brake",
        ),
    ] = 0.0

    @model_validator(mode="after")
    def _table(self) -> SpeedDrive:
        check_pairs(self, "times_s", "speeds_rpm")
        for key in ("times_s", "speeds_rpm"):
            if not isinstance(getattr(self, key), ColumnTable) and len(getattr(self, key)) < 2:
                raise ValueError(f"{key} has {len(getattr(self, key))} values. Set two or more")
        if not isinstance(self.times_s, ColumnTable) and self.times_s[0] != 0:
            raise ValueError(f"times_s starts at {self.times_s[0]:g} and must start at 0. Correct it")
        return self


class MotorsTable(SomewhereTable):
    """One motor somewhere on a shaft, or one at each end."""

    motors: Motors = 1

    @model_validator(mode="after")
    def _both_ends(self) -> MotorsTable:
        if self.motors == 2 and self.position_mm is not None:
            raise ValueError("motors = 2 are at both ends of the shaft. Delete position_mm, or set motors = 1")
        return self


class TorqueDrive(MotorsTable, TorqueCurve):
    """Motors of prescribed torque; the speed results from the motion."""

    model: Literal["torque"] = "torque"
    start_rpm: Annotated[Number, Field(description="speed of the shaft at t = 0")]
    highest_rpm: Annotated[
        Number | None,
        Field(gt=0, description="speed at which frequencies and strength are checked; without it: start_rpm"),
    ] = None


class InductionDrive(MotorsTable, InductionTable):
    """Induction motors on the mains, by their rating and the formula of Kloss."""

    start_rpm: Annotated[
        Number | None,
        Field(description="speed of the shaft at t = 0; without it: rated_rpm; 0: a start from standstill"),
    ] = None


class ControlledDrive(MotorsTable, ControlledTable):
    """Motors under PI speed control."""


def _speed_by_default(value: Any) -> Any:
    return {"model": "speed", **value} if isinstance(value, dict) and "model" not in value else value


DriveModel = Annotated[
    SpeedDrive | TorqueDrive | InductionDrive | ControlledDrive,
    Field(discriminator="model"),
    BeforeValidator(_speed_by_default),
]


class TorqueLoad(SomewhereTable, TorqueCurve):
    """A brake, fan or other machine that takes a torque; positive torques resist positive rotation."""

    model: Literal["torque"] = "torque"


class LoadBase(Table):
    """What every load has: a weight on two drums."""

    container_kg: Annotated[Number, Field(ge=0, description="hanging mass")]
    drum_radius_mm: Annotated[Number, Field(gt=0, description="radius to the centre of the rope")]
    drum_mass_kg: Annotated[Number, Field(gt=0, description="mass of each drum")]
    drum_inertia_kg_m2: Annotated[Number, Field(gt=0, description="moment of inertia of each drum about the shaft")]
    reeving_ratio: Annotated[
        Number, Field(gt=0, description="rope speed at the drum over speed of the hanging mass")
    ] = 2.0
    shaft: Annotated[
        Whole | None, Field(ge=1, description="number of the shaft of the drums; without it: the last")
    ] = None
    drum_positions_mm: Annotated[
        tuple[Number, ...], Field(description="y of the drums; empty: both ends of their shaft")
    ] = ()
    rope_direction_deg: Annotated[
        Number | None,
        Field(
            ge=-180,
            le=180,
            description="direction of the rope force on the drums: 0 is +x, 90 is up; without it: the drums load "
            "the shaft by torque only",
        ),
    ] = None


class StaticTorqueTable(LoadBase):
    """The weight of a hanging mass, as a constant torque on the drums."""

    model: Literal["static-torque"] = "static-torque"


class RopeTable(LoadBase):
    """A hanging mass on an elastic rope: stiffness of the current length, tension only."""

    model: Literal["rope"] = "rope"
    rope_diameter_mm: Annotated[Number, Field(gt=0, description="nominal diameter")] = 10.0
    rope_modulus_GPa: Annotated[Number, Field(gt=0, description="elastic modulus on the metallic area")] = 100.0
    rope_fill_factor: Annotated[
        Number, Field(gt=0, le=1, description="metallic area divided by the area of the circle")
    ] = 0.455
    rope_falls: Annotated[Whole, Field(ge=1, description="number of falls that carry the mass")] = 8
    rope_length_m: Annotated[Number, Field(gt=0, description="free length at t = 0")] = 5.0
    rope_damping_ratio: Annotated[
        Number, Field(ge=0, lt=1, description="damping ratio of the vertical vibration at the initial length")
    ] = 0.02
    ground_level_m: Annotated[
        Number | None,
        Field(
            description="height of the ground above the position of the mass on the unstretched rope "
            "at t = 0. If it is positive, the mass rests on the ground and the rope is "
            "slack by this amount; without it: no ground"
        ),
    ] = None
    ground_stiffness_N_per_um: Annotated[Number, Field(gt=0, description="stiffness of the ground")] = 10.0
    ground_damping_ratio: Annotated[
        Number, Field(ge=0, lt=10, description="damping ratio of the mass on the ground")
    ] = 0.1


class RopePendulumTable(RopeTable):
    """As rope, and the mass swings below a fixed trolley."""

    model: Literal["rope-pendulum"] = "rope-pendulum"  # type: ignore[assignment]
    sway_x_deg: Annotated[
        Number,
        Field(gt=-60, lt=60, description="angle of the ropes at t = 0 in the plane of x and z, released from rest"),
    ] = 0.0
    sway_y_deg: Annotated[
        Number, Field(gt=-60, lt=60, description="angle of the ropes at t = 0 in the plane of y and z")
    ] = 0.0


LoadModel = Annotated[TorqueLoad | StaticTorqueTable | RopeTable | RopePendulumTable, Field(discriminator="model")]


if TYPE_CHECKING:
    SimulationTable = Any
else:
    SimulationTable = table(MotionSettings)
