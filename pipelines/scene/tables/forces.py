"""Tables of forces from outside besides the load, each with what it is for the multibody model.

A new kind is a table here, in `ForceModel`, and its file in `mbd.forces` or `mbd.excitations`; nothing else knows the
kinds.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, model_validator

from pipelines.scene.tables.base import NotNegative, Number, Positive, Table, Whole

if TYPE_CHECKING:
    from mbd.excitations.waveform import Waveform
    from mbd.parts.load import Excitation, OutsideForce


class ForceBase(Table):
    """Where a force acts."""

    shaft: Annotated[Whole, Field(ge=1, description="number of the shaft")]
    position_mm: Annotated[Number, Field(description="y")]

    @property
    def positions(self) -> dict[str, float]:
        """Places (mm) on the shaft by key."""
        return {"position_mm": self.position_mm}

    def place(self, number: int) -> dict[str, Any]:
        """Name, shaft and y (m) of the force with a number in the scene."""
        return {"name": f"force_{number}", "shaft": f"shaft_{self.shaft}", "y": self.position_mm / 1000}


class SweepTable(Table):
    """A swept sine, its frequency linear in time; the envelope rises and falls as sin^2."""

    model: Literal["sweep"] = "sweep"
    start_s: Annotated[NotNegative, Field(description="when it starts")]
    end_s: Annotated[Positive, Field(description="when it ends")]
    from_Hz: Annotated[NotNegative, Field(description="at the start")]
    to_Hz: Annotated[NotNegative, Field(description="at the end")]
    ramp_s: Annotated[Positive, Field(description="length of the rise and of the fall")]

    @model_validator(mode="after")
    def _ramps_fit(self) -> SweepTable:
        if 2 * self.ramp_s > self.end_s - self.start_s:
            raise ValueError(f"ramp_s = {self.ramp_s:g} s fits not twice between {self.start_s:g} and {self.end_s:g} s")
        return self

    def wave(self, name: str, amplitude: float) -> Waveform:
        """The waveform in SI."""
        from mbd.excitations.waveform import SweepWave

        return SweepWave(
            name=name,
            start=self.start_s,
            end=self.end_s,
            first=self.from_Hz,
            last=self.to_Hz,
            ramp=self.ramp_s,
            amplitude=amplitude,
        )


class ForceSweepTable(SweepTable):
    """A swept sine, its frequency linear in time; the envelope rises and falls as sin^2."""

    amplitude_N: Annotated[Positive, Field(description="of the force")]

    def waveform(self, name: str) -> Waveform:
        """The force in SI."""
        return self.wave(name, self.amplitude_N)


class BaseSweepTable(SweepTable):
    """A swept sine, its frequency linear in time; the envelope rises and falls as sin^2."""

    amplitude_m_s2: Annotated[Positive, Field(description="of the acceleration")]

    def waveform(self, name: str) -> Waveform:
        """The acceleration in SI."""
        return self.wave(name, self.amplitude_m_s2)


class BaseTimesTable(Table):
    """Values over time, linear between the times and constant outside."""

    model: Literal["table"] = "table"
    times_s: Annotated[tuple[Number, ...], Field(min_length=1, description="strictly rising")]
    accelerations_m_s2: Annotated[tuple[Number, ...], Field(min_length=1, description="at these times")]

    @model_validator(mode="after")
    def _pairs(self) -> BaseTimesTable:
        check_pairs("accelerations_m_s2", self.times_s, self.accelerations_m_s2)
        return self

    def waveform(self, name: str) -> Waveform:
        """The acceleration in SI."""
        return table_wave(name, self.times_s, self.accelerations_m_s2)


class ForceTimesTable(Table):
    """Values over time, linear between the times and constant outside."""

    model: Literal["table"] = "table"
    times_s: Annotated[tuple[Number, ...], Field(min_length=1, description="strictly rising")]
    forces_N: Annotated[tuple[Number, ...], Field(min_length=1, description="at these times")]

    @model_validator(mode="after")
    def _pairs(self) -> ForceTimesTable:
        check_pairs("forces_N", self.times_s, self.forces_N)
        return self

    def waveform(self, name: str) -> Waveform:
        """The force in SI."""
        return table_wave(name, self.times_s, self.forces_N)


ForceOverTime = Annotated[ForceTimesTable | ForceSweepTable, Field(discriminator="model")]


def check_pairs(key: str, times: tuple[float, ...], values: tuple[float, ...]) -> None:
    """Raise ValueError unless there is a value of ``key`` for each of the rising times."""
    if len(times) != len(values):
        raise ValueError(f"times_s has {len(times)} values, {key} has {len(values)}")
    for before, after in zip(times, times[1:], strict=False):
        if after <= before:
            raise ValueError(f"times_s must rise strictly: {after} s follows {before} s")


def table_wave(name: str, times: tuple[float, ...], levels: tuple[float, ...]) -> Waveform:
    """The waveform of a table, in SI."""
    import numpy as np

    from mbd.excitations.waveform import TableWave

    return TableWave(name=name, times=np.array(times), levels=np.array(levels))


class TorqueTable(ForceBase):
    """A torque over time on a shaft, linear between the times and constant outside."""

    model: Literal["torque"] = "torque"
    times_s: Annotated[tuple[Number, ...], Field(min_length=1, description="strictly rising")]
    torques_N_m: Annotated[
        tuple[Number, ...], Field(min_length=1, description="at these times, positive in the lifting sense")
    ]

    @model_validator(mode="after")
    def _pairs(self) -> TorqueTable:
        check_pairs("torques_N_m", self.times_s, self.torques_N_m)
        return self

    def spec(self, number: int) -> OutsideForce:
        """The force in SI."""
        import numpy as np

        from mbd.forces.torque import Torque

        return Torque(**self.place(number), times=np.array(self.times_s), torques=np.array(self.torques_N_m))


class UnbalanceTable(ForceBase):
    """A mass off the axis of a shaft, that turns with it."""

    model: Literal["unbalance"] = "unbalance"
    unbalance_g_mm: Annotated[Positive, Field(description="mass times radius")]
    angle_deg: Annotated[Number, Field(description="of the heavy spot at t = 0, from +x towards +z")] = 0.0

    def spec(self, number: int) -> OutsideForce:
        """The force in SI."""
        from mbd.excitations.unbalance import Unbalance

        return Unbalance(**self.place(number), size=self.unbalance_g_mm / 1_000_000, angle=math.radians(self.angle_deg))


class TorqueRippleTable(ForceBase):
    """A torque that goes by the angle of a shaft, at an order of its rotation."""

    model: Literal["torque-ripple"] = "torque-ripple"
    amplitude_N_m: Annotated[Positive, Field(description="of the torque")]
    order: Annotated[Positive, Field(description="periods per turn of the shaft")]
    phase_deg: Annotated[Number, Field(description="at t = 0, of a cosine")] = 0.0

    def spec(self, number: int) -> OutsideForce:
        """The torque in SI."""
        from mbd.excitations.ripple import TorqueRipple

        phase = math.radians(self.phase_deg)
        return TorqueRipple(**self.place(number), amplitude=self.amplitude_N_m, order=self.order, angle=phase)


class BentShaftTable(ForceBase):
    """A shaft with a fixed bow, as bent by a force between two places where it is straight."""

    model: Literal["bent-shaft"] = "bent-shaft"
    bow_um: Annotated[Positive, Field(description="at position_mm, of the axis off its straight line")]
    straight_at_mm: Annotated[tuple[Number, Number], Field(description="y of two places without bow: the bearings")]
    angle_deg: Annotated[Number, Field(description="of the bow at t = 0, from +x towards +z")] = 0.0

    @model_validator(mode="after")
    def _apart(self) -> BentShaftTable:
        if len({self.position_mm, *self.straight_at_mm}) < 3:
            raise ValueError(
                f"straight_at_mm = {list(self.straight_at_mm)}: give two places beside position_mm = "
                f"{self.position_mm:g}, e.g. the bearings"
            )
        return self

    @property
    def positions(self) -> dict[str, float]:
        """Places (mm) on the shaft by key."""
        return super().positions | {f"straight_at_mm.{n}": y for n, y in enumerate(self.straight_at_mm, 1)}

    def spec(self, number: int) -> OutsideForce:
        """The bow in SI."""
        from mbd.excitations.bent_shaft import BentShaft

        return BentShaft(
            **self.place(number),
            bow=self.bow_um / 1_000_000,
            straight=(self.straight_at_mm[0] / 1000, self.straight_at_mm[1] / 1000),
            angle=math.radians(self.angle_deg),
        )


Axis = Annotated[Literal["x", "y", "z"], Field(description="along which it acts")]


class ShaftForceTable(ForceBase):
    """A force over time on a shaft."""

    model: Literal["shaft-force"] = "shaft-force"
    axis: Axis
    force: ForceOverTime

    def spec(self, number: int) -> OutsideForce:
        """The force in SI."""
        from mbd.excitations.outside_force import ShaftForce

        place = self.place(number)
        return ShaftForce(**place, axis=self.axis, force=self.force.waveform(place["name"]))


class CasingForceTable(Table):
    """A force over time on the casing, at the place of a sensor."""

    model: Literal["casing-force"] = "casing-force"
    point: Annotated[str, Field(description="name of the sensor at whose place it acts")]
    axis: Annotated[Literal["x", "y", "z"], Field(description="channel of the sensor along which it acts")]
    force: ForceOverTime

    def spec(self, number: int) -> Excitation:
        """The force in SI."""
        from mbd.excitations.outside_force import CasingForce

        name = f"force_{number}"
        return CasingForce(name=name, point=self.point, axis=self.axis, force=self.force.waveform(name))


class BaseAccelerationTable(Table):
    """Acceleration over time of the ground under all feet together, and of what else stands on the ground."""

    model: Literal["base-acceleration"] = "base-acceleration"
    axis: Axis
    acceleration: Annotated[BaseTimesTable | BaseSweepTable, Field(discriminator="model")]

    def spec(self, number: int) -> Excitation:
        """The acceleration in SI."""
        from mbd.excitations.base_acceleration import BaseAcceleration

        name = f"force_{number}"
        return BaseAcceleration(name=name, axis=self.axis, acceleration=self.acceleration.waveform(name))


ForceModel = Annotated[
    TorqueTable
    | TorqueRippleTable
    | UnbalanceTable
    | BentShaftTable
    | ShaftForceTable
    | CasingForceTable
    | BaseAccelerationTable,
    Field(discriminator="model"),
]
