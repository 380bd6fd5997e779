"""Tables of drive and load, and what each gives the machine in SI: places on the shaft, speeds, torques, masses."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Any, ClassVar, Literal, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from mbd.forces.hanging_loads import LOADS, HangingLoad, StaticTorqueLoad, load_model
from mbd.forces.induction_motor import InductionMotor
from mbd.forces.speed_controller import SpeedController
from mbd.forces.torque_source import TorqueSource
from mbd.parts.load import Load
from mbd.parts.speed_drive import MotorCoupling, SpeedProfile
from pipelines.scene.tables.derived import DerivedTable, by_default, choice, table
from pipelines.scene.tables.scene_table import Number, Table, Whole
from pipelines.scene.tables.series import Samples, check_pairs, in_file, pairs, refused
from pipelines.scene.tables.shafts import ShaftTable
from pipelines.scene.tables.torques import RPM, SomewhereTable, TorqueCurve

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
            if not in_file(given := getattr(self, key)) and len(given) < 2:
                raise ValueError(f"{key} has {len(given)} values. Set two or more")
        times: Any = self.times_s
        if not in_file(times) and times[0] != 0:
            raise ValueError(f"times_s starts at {times[0]:g} and must start at 0. Correct it")
        return self

    speed_is_known: ClassVar[bool] = True
    speed_key: ClassVar[str] = "drive.speeds_rpm"

    @property
    def brake_torque(self) -> float:
        """Torque of the holding brake (N m); 0: no brake."""
        return self.brake_torque_N_m

    @property
    def highest_turns(self) -> float:
        """Highest speed (1/s), for which frequencies and strength are stated."""
        return _highest_turns(self)

    def motor_places(self, shaft: ShaftTable) -> tuple[float, ...]:
        """y of the motors (m) on their shaft."""
        return shaft.ends[: self.motors]

    def profile(self) -> SpeedProfile:
        """Speed of the motors over time. SceneError for a file that cannot be used."""
        times, speeds = pairs(self, "times_s", "speeds_rpm", "drive")
        if times[0] > 0.0:
            raise refused("drive.times_s", f"starts at {times[0]:g} s, and must start at 0", "Correct the file")
        return SpeedProfile(times=times, speeds=speeds * RPM, smooth=in_file(self.speeds_rpm))

    def couplings(self, shaft: str, places: tuple[float, ...]) -> tuple[MotorCoupling, ...]:
        """Couplings to the motors at y (m) of a shaft."""
        return tuple(
            MotorCoupling(
                name=f"motor_{number}",
                shaft=shaft,
                y=y,
                stiffness=self.coupling_stiffness_N_m_per_rad,
                damping=self.coupling_damping_N_m_s_per_rad,
            )
            for number, y in enumerate(places, 1)
        )

    def torque_sources(self, shaft: str, places: tuple[float, ...]) -> tuple[TorqueSource, ...]:
        """None: the torque follows from the speed."""
        return ()


def _highest_turns(drive: Any) -> float:
    return float(abs(pairs(drive, "times_s", "speeds_rpm", "drive")[1]).max()) / 60


class MotorsTable(SomewhereTable):
    """One motor somewhere on a shaft, or one at each end, which give a torque; the speed results from the motion."""

    motors: Motors = 1

    speed_is_known: ClassVar[bool] = False
    speed_key: ClassVar[str] = "drive"
    brake_torque: ClassVar[float] = 0.0

    @model_validator(mode="after")
    def _both_ends(self) -> MotorsTable:
        if self.motors == 2 and self.position_mm is not None:
            raise ValueError("motors = 2 are at both ends of the shaft. Delete position_mm, or set motors = 1")
        return self

    @property
    @abstractmethod
    def starting_rpm(self) -> float:
        """Speed of the driven shaft at t = 0 (rpm)."""

    @property
    @abstractmethod
    def highest_turns(self) -> float:
        """Speed (1/s) for which frequencies and strength are stated."""

    @abstractmethod
    def motor(self, where: dict[str, Any]) -> TorqueSource:
        """One motor, with its name, shaft and place."""

    def motor_places(self, shaft: ShaftTable) -> tuple[float, ...]:
        """y of the motors (m) on their shaft."""
        return shaft.ends[: self.motors] if self.position_mm is None else (self.si.position,)

    def profile(self) -> SpeedProfile:
        """The speed at t = 0 alone."""
        return SpeedProfile(times=np.zeros(1), speeds=np.array([self.starting_rpm * RPM]))

    def couplings(self, shaft: str, places: tuple[float, ...]) -> tuple[MotorCoupling, ...]:
        """None: the motors are on the shaft itself."""
        return ()

    def torque_sources(self, shaft: str, places: tuple[float, ...]) -> tuple[TorqueSource, ...]:
        """The motors at y (m) of a shaft."""
        return tuple(
            self.motor({"name": f"motor_{number}", "shaft": shaft, "y": y, "drives": True})
            for number, y in enumerate(places, 1)
        )


class TorqueDrive(MotorsTable, TorqueCurve):
    """Motors of prescribed torque; the speed results from the motion."""

    model: Literal["torque"] = "torque"
    start_rpm: Annotated[Number, Field(description="speed of the shaft at t = 0")]
    highest_rpm: Annotated[
        Number | None,
        Field(gt=0, description="speed at which frequencies and strength are checked; without it: start_rpm"),
    ] = None

    @property
    def starting_rpm(self) -> float:
        """The given speed at t = 0 (rpm)."""
        return self.start_rpm

    @property
    def highest_turns(self) -> float:
        """The given highest speed, otherwise that at t = 0 (1/s)."""
        return (self.highest_rpm or abs(self.start_rpm)) / 60

    def motor(self, where: dict[str, Any]) -> TorqueSource:
        """One motor, with its name, shaft and place."""
        return self.curve(where, 1.0, "drive")


class _MotorsBase(MotorsTable, DerivedTable):
    """Motors whose torque follows from their speed."""

    use = "Drive"

    @model_validator(mode="after")
    def _fits(self) -> _MotorsBase:
        """What a motor refuses is a problem of the table; speeds over time are checked on their own."""
        if not self.series:
            self.made(name="motor", shaft="shaft_1", y=0.0)
        return self

    def motor(self, where: dict[str, Any]) -> TorqueSource:
        """One motor, with its name, shaft and place."""
        return self.made("drive", **where)


class _ControlledBase(_MotorsBase):
    """Motors that follow a speed over time."""

    @property
    def starting_rpm(self) -> float:
        """The set speed at t = 0 (rpm)."""
        return float(np.interp(0.0, *pairs(self, "times_s", "speeds_rpm", "drive")))

    @property
    def highest_turns(self) -> float:
        """Highest set speed (1/s)."""
        return _highest_turns(self)


class _InductionBase(_MotorsBase):
    """Where the motors start."""

    start_rpm: Annotated[
        Number | None,
        Field(description="speed of the shaft at t = 0; without it: rated_rpm; 0: a start from standstill"),
    ] = None

    @property
    def starting_rpm(self) -> float:
        """Speed of the driven shaft at t = 0 (rpm)."""
        return self.rated_rpm if self.start_rpm is None else self.start_rpm

    @property
    def highest_turns(self) -> float:
        """The rated speed (1/s)."""
        return self.rated_rpm / 60


class TorqueLoad(SomewhereTable, TorqueCurve):
    """A brake, fan or other machine that takes a torque; positive torques resist positive rotation."""

    model: Literal["torque"] = "torque"

    places_key: ClassVar[str] = "load.position_mm"
    without_load: ClassVar[tuple[str, str]] = (
        "load: the torque is 0",
        "Set load.torque_N_m for a simulation, or --torque of gearcase gears",
    )

    @property
    def suspended(self) -> HangingLoad | None:
        """None: there are no drums."""
        return None

    @property
    def torque(self) -> float:
        """Torque of greatest magnitude (N m) with which the load resists the rotation of its shaft."""
        return -self.torque_sources("", (0.0,))[0].largest

    def places(self, shaft: ShaftTable) -> tuple[float, ...]:
        """y (m) where the torque acts on its shaft, by default the +y end."""
        return (shaft.ends[1] if self.position_mm is None else self.si.position,)

    def hanging_load(self, shaft: str, places: tuple[float, ...]) -> Load | None:
        """None: there are no drums."""
        return None

    def torque_sources(self, shaft: str, places: tuple[float, ...]) -> tuple[TorqueSource, ...]:
        """The torque at y (m) of a shaft."""
        return (self.curve({"name": "load", "shaft": shaft, "y": places[0]}, -1.0, "load"),)


class LoadBase(DerivedTable):
    """Places of the drums that carry a hanging mass."""

    shaft: Annotated[
        Whole | None, Field(ge=1, description="number of the shaft of the drums; without it: the last")
    ] = None
    drum_positions_mm: Annotated[
        tuple[Number, ...], Field(description="y of the drums; empty: both ends of their shaft")
    ] = ()

    places_key: ClassVar[str] = "load.drum_positions_mm"
    without_load: ClassVar[tuple[str, str]] = ("load.container_kg = 0", "Increase load.container_kg")

    @property
    def suspended(self) -> HangingLoad | None:
        """The mass on the ropes of the drums."""
        return self.made()

    @property
    def torque(self) -> float:
        """Torque (N m) with which the weight resists the rotation of its shaft."""
        return self.made().torque

    def places(self, shaft: ShaftTable) -> tuple[float, ...]:
        """y (m) of the drums on their shaft."""
        return self.si.drum_positions or shaft.ends

    def hanging_load(self, shaft: str, places: tuple[float, ...]) -> Load | None:
        """The mass on drums at y (m) of a shaft. MachineError if its values do not fit together."""
        return self.made().load(shaft, places)

    def torque_sources(self, shaft: str, places: tuple[float, ...]) -> tuple[TorqueSource, ...]:
        """None: the torque follows from the mass."""
        return ()


StaticTorqueTable = table(StaticTorqueLoad, LoadBase)
DriveModel: TypeAlias = Annotated[
    choice(
        (SpeedDrive, TorqueDrive, table(InductionMotor, _InductionBase), table(SpeedController, _ControlledBase)),
        "model",
    ),
    by_default("speed"),
]
LoadModel: TypeAlias = choice((TorqueLoad, *(table(load_model(name), LoadBase) for name in LOADS)), "model")
