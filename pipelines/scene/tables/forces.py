"""Tables of external forces other than drive and load, with their conversion to the multibody model.

The tables of `mbd.excitations.excitation_registry` are derived from its classes. Any other kind has a table here, in
`ForceModel`, and a class in `mbd.forces`; no other file depends on the kinds.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from mbd.excitations.excitation_registry import EXCITATIONS, excitation_class
from mbd.parts.load import Excitation, OutsideForce
from pipelines.scene.tables.derived import DerivedTable, choice, table
from pipelines.scene.tables.scene_table import Number, Table, Whole
from pipelines.scene.tables.torques import TorqueCurve


class PlacedTable(Table):
    """Position of a force on a shaft; it has no default."""

    shaft: Annotated[Whole, Field(ge=1, description="number of the shaft")]
    position_mm: Annotated[Number, Field(description="y of the place where it acts")]

    @property
    def positions(self) -> dict[str, float]:
        """Positions (mm) on the shaft by key."""
        return {"position_mm": self.position_mm}

    def place(self, number: int) -> dict[str, Any]:
        """Name, shaft and y (m) of the force with a number in the scene."""
        return {"name": f"force_{number}", "shaft": f"shaft_{self.shaft}", "y": self.si.position}


class TorqueTable(PlacedTable, TorqueCurve):
    """A torque on a shaft: constant, over time or over speed; positive in the sense of rotation."""

    model: Literal["torque"] = "torque"

    def spec(self, number: int) -> OutsideForce:
        """The torque in SI."""
        return self.curve(self.place(number), 1.0, f"forces.{number}")


class ExcitationBase(DerivedTable):
    """An excitation of `mbd.excitations.excitation_registry`."""

    @property
    def positions(self) -> dict[str, float]:
        """Positions (mm) on the shaft by key; none for a force that acts elsewhere."""
        return {}

    @model_validator(mode="after")
    def _fits(self) -> Self:
        """Raise an error of the excitation as a problem of the table; values over time are checked separately."""
        if not self.series and not any(isinstance(value, DerivedTable) for _, value in self):
            self.spec(1)
        return self

    def place(self, number: int) -> dict[str, Any]:
        """Name of the force with a number in the scene."""
        return {"name": f"force_{number}"}

    def spec(self, number: int) -> Excitation:
        """The excitation in SI."""
        return self.made(f"forces.{number}", **self.place(number))


class ShaftExcitationBase(PlacedTable, ExcitationBase):
    """Where an excitation acts on a shaft."""


class BentShaftBase(ShaftExcitationBase):
    """Where a shaft is bent."""

    @property
    def positions(self) -> dict[str, float]:
        """Positions (mm) on the shaft by key."""
        return super().positions | {f"straight_at_mm.{n}": y for n, y in enumerate(self.straight_at_mm, 1)}


_BASES = {"bent-shaft": BentShaftBase, "casing-force": ExcitationBase, "base-acceleration": ExcitationBase}
ForceModel: TypeAlias = choice(
    (
        TorqueTable,
        *(table(excitation_class(name), _BASES.get(name, ShaftExcitationBase)) for name in EXCITATIONS),
    ),
    "model",
)
