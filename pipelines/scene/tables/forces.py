"""Tables of forces from outside besides drive and load, each with what it is for the multibody model.

A new kind is a table here, in `ForceModel`, and its class in `mbd`; nothing else knows the kinds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from pipelines.scene.tables.base import Number, Table, Whole
from pipelines.scene.tables.torques import ControlledTable, InductionTable, TorqueCurve

if TYPE_CHECKING:
    from mbd.parts.load import OutsideForce


class PlacedTable(Table):
    """Where a force acts: it must be said."""

    shaft: Annotated[Whole, Field(ge=1, description="number of the shaft")]
    position_mm: Annotated[Number, Field(description="y")]

    def place(self, number: int) -> tuple[str, int, float]:
        """Name, shaft (from 0) and y (m) of the force with a number in the scene."""
        return f"force_{number}", self.shaft - 1, self.position_mm / 1000


class TorqueTable(PlacedTable, TorqueCurve):
    """A torque on a shaft: constant, over time or over speed; positive values drive in the positive sense."""

    model: Literal["torque"] = "torque"

    def spec(self, number: int) -> OutsideForce:
        """The torque in SI."""
        return self.curve(self.at(*self.place(number)), 1.0, f"forces.{number}")


class FurtherInductionMotor(PlacedTable, InductionTable):
    """A further induction motor."""

    def spec(self, number: int) -> OutsideForce:
        """The motor in SI."""
        return self.motor(self.at(*self.place(number)))


class FurtherControlledMotor(PlacedTable, ControlledTable):
    """A further motor under speed control."""

    def spec(self, number: int) -> OutsideForce:
        """The motor in SI."""
        return self.motor(self.at(*self.place(number)), f"forces.{number}")


ForceModel = Annotated[TorqueTable | FurtherInductionMotor | FurtherControlledMotor, Field(discriminator="model")]
