"""Tables of forces from outside besides drive and load, each with what it is for the multibody model.

Those of `mbd.excitations.registry` have derived tables. Any other kind is a table here, in `ForceModel`, and its class
in `mbd.forces` or `mbd.excitations`; nothing else knows the kinds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from mbd.excitations.registry import EXCITATIONS, excitation_class
from pipelines.scene.tables.base import NotNegative, Number, Positive, Table, Whole
from pipelines.scene.tables.derived import DerivedTable, choice, table
from pipelines.scene.tables.samples import Samples, check_pairs, pairs
from pipelines.scene.tables.torques import ControlledTable, InductionTable, TorqueCurve

if TYPE_CHECKING:
    from mbd.excitations.waveform import Waveform
    from mbd.parts.load import Excitation, OutsideForce


class PlacedTable(Table):
    """Where a force acts on a shaft: it must be said."""

    shaft: Annotated[Whole, Field(ge=1, description="number of the shaft")]
    position_mm: Annotated[Number, Field(description="y of the place where it acts")]

    @property
    def positions(self) -> dict[str, float]:
        """Places (mm) on the shaft by key."""
        return {"position_mm": self.position_mm}

    def place(self, number: int) -> dict[str, Any]:
        """Name, shaft and y (m) of the force with a number in the scene."""
        return {"name": f"force_{number}", "shaft": f"shaft_{self.shaft}", "y": self.si.position}

    def source(self, number: int) -> tuple[str, int, float]:
        """Name, shaft (from 0) and y (m) of the torque source with a number in the scene."""
        return f"force_{number}", self.shaft - 1, self.si.position


class SweepTable(Table):
    """A swept sine: frequency linear in time, amplitude rising and falling as sin^2; `amplitude` is the key of it."""

    amplitude: ClassVar[str]
    model: Literal["sweep"] = "sweep"
    start_s: Annotated[NotNegative, Field(description="start of the sweep")]
    end_s: Annotated[Positive, Field(description="end of the sweep")]
    from_Hz: Annotated[NotNegative, Field(description="frequency at the start")]
    to_Hz: Annotated[NotNegative, Field(description="frequency at the end")]
    ramp_s: Annotated[Positive, Field(description="length of the rise and of the fall")]

    @model_validator(mode="after")
    def _ramps_fit(self) -> SweepTable:
        if 2 * self.ramp_s > self.end_s - self.start_s:
            raise ValueError(
                f"ramp_s = {self.ramp_s:g} is more than half of start_s = {self.start_s:g} to end_s = {self.end_s:g}. "
                "Reduce it"
            )
        return self

    def waveform(self, name: str) -> Waveform:
        """The value over time in SI."""
        from mbd.excitations.waveform import SweepWave

        return SweepWave(
            name=name,
            start=self.start_s,
            end=self.end_s,
            first=self.from_Hz,
            last=self.to_Hz,
            ramp=self.ramp_s,
            amplitude=getattr(self, self.amplitude),
        )


class ForceSweepTable(SweepTable):
    """A swept sine: frequency linear in time, amplitude rising and falling as sin^2."""

    amplitude: ClassVar[str] = "amplitude_N"
    amplitude_N: Annotated[Positive, Field(description="amplitude of the force")]


class BaseSweepTable(SweepTable):
    """A swept sine: frequency linear in time, amplitude rising and falling as sin^2."""

    amplitude: ClassVar[str] = "amplitude_m_s2"
    amplitude_m_s2: Annotated[Positive, Field(description="amplitude of the acceleration")]


class TimesTable(Table):
    """Values over time, linear between the times and constant outside; `levels` is the key of the values."""

    levels: ClassVar[str]
    model: Literal["table"] = "table"
    times_s: Annotated[Samples, Field(description="times, strictly rising")]

    @model_validator(mode="after")
    def _pairs(self) -> TimesTable:
        check_pairs(self, "times_s", self.levels)
        return self

    def waveform(self, name: str) -> Waveform:
        """The value over time in SI."""
        from mbd.excitations.waveform import TableWave

        times, values = pairs(self, "times_s", self.levels, f"{name} ([[forces]])")
        return TableWave(name=name, times=times, levels=values)


class BaseTimesTable(TimesTable):
    """Values over time, linear between the times and constant outside."""

    levels: ClassVar[str] = "accelerations_m_s2"
    accelerations_m_s2: Annotated[Samples, Field(description="acceleration at these times")]


class ForceTimesTable(TimesTable):
    """Values over time, linear between the times and constant outside."""

    levels: ClassVar[str] = "forces_N"
    forces_N: Annotated[Samples, Field(description="force at these times")]


ForceOverTime = Annotated[ForceTimesTable | ForceSweepTable, Field(discriminator="model")]


class TorqueTable(PlacedTable, TorqueCurve):
    """A torque on a shaft: constant, over time or over speed; positive in the sense of rotation."""

    model: Literal["torque"] = "torque"

    def spec(self, number: int) -> OutsideForce:
        """The torque in SI."""
        return self.curve(self.at(*self.source(number)), 1.0, f"forces.{number}")


class FurtherInductionMotor(PlacedTable, InductionTable):
    """A further induction motor on the mains, by its rating and the formula of Kloss."""

    def spec(self, number: int) -> OutsideForce:
        """The motor in SI."""
        return self.motor(self.at(*self.source(number)))


class FurtherControlledMotor(PlacedTable, ControlledTable):
    """A further motor under PI speed control."""

    def spec(self, number: int) -> OutsideForce:
        """The motor in SI."""
        return self.motor(self.at(*self.source(number)), f"forces.{number}")


class UnbalanceTable(PlacedTable):
    """A rotating unbalance."""

    model: Literal["unbalance"] = "unbalance"
    unbalance_g_mm: Annotated[Positive, Field(description="mass times radius")]
    angle_deg: Annotated[Number, Field(description="angle of the heavy spot at t = 0, from +x towards +z")] = 0.0

    def spec(self, number: int) -> OutsideForce:
        """The force in SI."""
        from mbd.excitations.unbalance import Unbalance

        return Unbalance(**self.place(number), size=self.si.unbalance, angle=self.si.angle)


class BentShaftTable(PlacedTable):
    """A bent shaft, bowed as by a force at position_mm between two places that stay straight."""

    model: Literal["bent-shaft"] = "bent-shaft"
    bow_um: Annotated[Positive, Field(description="distance of the bent axis from the straight one at position_mm")]
    straight_at_mm: Annotated[
        tuple[Number, Number], Field(description="y of two places without bow, usually the bearings")
    ]
    angle_deg: Annotated[Number, Field(description="angle of the bow at t = 0, from +x towards +z")] = 0.0

    @model_validator(mode="after")
    def _apart(self) -> BentShaftTable:
        if len({self.position_mm, *self.straight_at_mm}) < 3:
            raise ValueError(
                f"straight_at_mm = {list(self.straight_at_mm)} must be two places other than position_mm = "
                f"{self.position_mm:g}. Set them, usually to the bearings"
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
            bow=self.si.bow,
            straight=self.si.straight_at,
            angle=self.si.angle,
        )


Axis = Annotated[Literal["x", "y", "z"], Field(description="direction in which it acts")]


class ShaftForceTable(PlacedTable):
    """A force over time on a shaft."""

    model: Literal["shaft-force"] = "shaft-force"
    axis: Axis
    force: Annotated[ForceOverTime, Field(description="force over time")]

    def spec(self, number: int) -> OutsideForce:
        """The force in SI."""
        from mbd.excitations.outside_force import ShaftForce

        place = self.place(number)
        return ShaftForce(**place, axis=self.axis, force=self.force.waveform(place["name"]))


class CasingForceTable(Table):
    """A force over time on the casing, at a sensor."""

    model: Literal["casing-force"] = "casing-force"
    point: Annotated[str, Field(description="name of the sensor where it acts")]
    axis: Annotated[Literal["x", "y", "z"], Field(description="channel of that sensor in whose direction it acts")]
    force: Annotated[ForceOverTime, Field(description="force over time")]

    def spec(self, number: int) -> Excitation:
        """The force in SI."""
        from mbd.excitations.outside_force import CasingForce

        name = f"force_{number}"
        return CasingForce(name=name, point=self.point, axis=self.axis, force=self.force.waveform(name))


class BaseAccelerationTable(Table):
    """An acceleration of the ground over time: of all feet, and of everything else that is on the ground."""

    model: Literal["base-acceleration"] = "base-acceleration"
    axis: Axis
    acceleration: Annotated[
        BaseTimesTable | BaseSweepTable, Field(discriminator="model", description="acceleration over time")
    ]

    def spec(self, number: int) -> Excitation:
        """The acceleration in SI."""
        from mbd.excitations.base_acceleration import BaseAcceleration

        name = f"force_{number}"
        return BaseAcceleration(name=name, axis=self.axis, acceleration=self.acceleration.waveform(name))


class ExcitationBase(PlacedTable, DerivedTable):
    """Where an excitation of `mbd.excitations.registry` acts."""

    def spec(self, number: int) -> OutsideForce:
        """The excitation in SI."""
        made: OutsideForce = self.made(**self.place(number))
        return made


if TYPE_CHECKING:
    ForceModel = Any
else:
    ForceModel = choice(
        (
            TorqueTable,
            FurtherInductionMotor,
            FurtherControlledMotor,
            *(table(excitation_class(name), ExcitationBase) for name in EXCITATIONS),
            UnbalanceTable,
            BentShaftTable,
            ShaftForceTable,
            CasingForceTable,
            BaseAccelerationTable,
        ),
        "model",
    )
