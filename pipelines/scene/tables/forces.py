"""Tables of forces from outside besides the load, each with what it is for the multibody model.

A new kind is a table here, in `ForceModel`, and its file in `mbd.forces` or `mbd.excitations`; nothing else knows the
kinds.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, model_validator

from pipelines.scene.tables.base import Number, Positive, Table, Whole

if TYPE_CHECKING:
    from mbd.parts.load import OutsideForce


class ForceBase(Table):
    """Where a force acts."""

    shaft: Annotated[Whole, Field(ge=1, description="number of the shaft")]
    position_mm: Annotated[Number, Field(description="y")]

    def place(self, number: int) -> dict[str, Any]:
        """Name, shaft and y (m) of the force with a number in the scene."""
        return {"name": f"force_{number}", "shaft": f"shaft_{self.shaft}", "y": self.position_mm / 1000}


class TorqueTable(ForceBase):
    """A torque over time on a shaft, linear between the times and constant outside."""

    model: Literal["torque"] = "torque"
    times_s: Annotated[tuple[Number, ...], Field(min_length=1, description="strictly rising")]
    torques_N_m: Annotated[
        tuple[Number, ...], Field(min_length=1, description="at these times, positive in the lifting sense")
    ]

    @model_validator(mode="after")
    def _pairs(self) -> TorqueTable:
        if len(self.times_s) != len(self.torques_N_m):
            raise ValueError(f"times_s has {len(self.times_s)} values, torques_N_m has {len(self.torques_N_m)}")
        for before, after in zip(self.times_s, self.times_s[1:], strict=False):
            if after <= before:
                raise ValueError(f"times_s must rise strictly: {after} s follows {before} s")
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


ForceModel = Annotated[TorqueTable | UnbalanceTable, Field(discriminator="model")]
