"""Tables of faults, one each with its severity: damaged teeth, and spalls of rolling bearings."""

from __future__ import annotations

from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from fem.contact.faults.fault_registry import FAULTS, fault_class
from mbd.excitations.spall import Spall
from pipelines.scene.tables.derived import DerivedTable, choice, table
from pipelines.scene.tables.scene_table import Whole


class FaultBase(DerivedTable):
    """Which tooth is damaged."""

    stage: Annotated[Whole, Field(ge=1, description="number of the stage")]
    gear: Annotated[Literal["pinion", "wheel"], Field(description="gear of that stage")]
    tooth: Annotated[
        Whole, Field(ge=0, description="number of the tooth; tooth 0 touches at the pitch point at mesh cycle c = 0")
    ]


class WearBase(FaultBase):
    """Which tooth is worn."""

    tooth: Annotated[Whole | None, Field(ge=0, description="number of the tooth; without it: all teeth")] = None  # type: ignore[assignment]

    @model_validator(mode="after")
    def _part_of_one_tooth(self) -> Self:
        if self.tooth is None and getattr(self, "extent_mm", None) is not None:
            raise ValueError(
                "extent_mm: only a single tooth can be worn on a part of the face. Set tooth, or delete extent_mm and "
                "set the worn flanks of all teeth by stages.N.pinion.deviations.flanks.file"
            )
        return self


class SpallBase(DerivedTable):
    """Which bearing is damaged."""

    shaft: Annotated[Whole, Field(ge=1, description="number of the shaft")]
    bearing: Annotated[Whole, Field(ge=1, description="number of the bearing on that shaft; 1 is nearest to -y")]


SPALL = "bearing-spall"  # the kind of fault of a bearing; all others are of teeth
_BASES = {"worn-tooth": WearBase}
BearingSpallTable: TypeAlias = table(Spall, SpallBase, kind=(SPALL, "what is wrong with the bearing"))
FaultTable: TypeAlias = choice(
    (
        table(fault_class(kind), _BASES.get(kind, FaultBase), kind=(kind, "what is wrong with the tooth"))
        for kind in FAULTS
    ),
    "kind",
)
AnyFaultTable: TypeAlias = Annotated[FaultTable | BearingSpallTable, Field(discriminator="kind")]
