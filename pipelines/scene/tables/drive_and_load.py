"""Tables of drive and load."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BeforeValidator, Field, model_validator

from mbd.forces.hanging_loads import LOADS, StaticTorqueLoad, load_model
from mbd.forces.induction_motor import InductionMotor
from mbd.forces.speed_controller import SpeedController
from pipelines.scene.tables.derived import DerivedTable, choice, table
from pipelines.scene.tables.scene_table import Number, Table, Whole
from pipelines.scene.tables.series import ColumnTable, Samples, check_pairs
from pipelines.scene.tables.torques import SomewhereTable, TorqueCurve

Motors = Annotated[Literal[1, 2], Field(description="2: one motor at each end of the shaft; 1: one motor")]


class SpeedDrive(Table):
    """Motors of prescribed speed at the ends of a shaft, through couplings that transmit torque only."""

    model: Literal["speed"] = "speed"
    times_s: Annotated[Samples, Field(description="two or more times, strictly ascending from 0")]
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
            description="torque of a holding brake on that shaft at the first motor. The brake is closed while "
            "the motors stand still; 0: no brake",
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


class _MotorsBase(MotorsTable, DerivedTable):
    """Motors whose torque follows from their speed."""

    use = "Drive"

    @model_validator(mode="after")
    def _fits(self) -> _MotorsBase:
        """What a motor refuses is a problem of the table; speeds over time are checked on their own."""
        if not self.series:
            self.made(name="motor", shaft="shaft_1", y=0.0)
        return self


class _InductionBase(_MotorsBase):
    """Where the motors start."""

    start_rpm: Annotated[
        Number | None,
        Field(description="speed of the shaft at t = 0; without it: rated_rpm; 0: a start from standstill"),
    ] = None


def _speed_by_default(value: Any) -> Any:
    return {"model": "speed", **value} if isinstance(value, dict) and "model" not in value else value


class TorqueLoad(SomewhereTable, TorqueCurve):
    """A brake, fan or other machine that takes a torque; positive torques resist positive rotation."""

    model: Literal["torque"] = "torque"


class LoadBase(DerivedTable):
    """Places of the drums that carry a hanging mass."""

    shaft: Annotated[
        Whole | None, Field(ge=1, description="number of the shaft of the drums; without it: the last")
    ] = None
    drum_positions_mm: Annotated[
        tuple[Number, ...], Field(description="y of the drums; empty: both ends of their shaft")
    ] = ()


StaticTorqueTable = table(StaticTorqueLoad, LoadBase)
DriveModel: TypeAlias = Annotated[
    choice(
        (SpeedDrive, TorqueDrive, table(InductionMotor, _InductionBase), table(SpeedController, _MotorsBase)),
        "model",
    ),
    BeforeValidator(_speed_by_default),
]
LoadModel: TypeAlias = choice((TorqueLoad, *(table(load_model(name), LoadBase) for name in LOADS)), "model")
