"""Tables of the deviations of one gear that are stated one by one; positive where there is more material."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import Field, model_validator

from fem.gears.prescribed import Eccentricity, ToothError, Wave
from pipelines.scene.tables.base import Table
from pipelines.scene.tables.derived import table

EccentricTable: Any = table(Eccentricity)
WaveTable: TypeAlias = table(Wave)
ToothErrorTable: TypeAlias = table(ToothError)


class MeasuredFlanksTable(Table):
    """Deviations at points of the flanks, as from a gear measuring machine: see docs/flank-deviations.md."""

    file: Annotated[
        str, Field(min_length=1, description="CSV or netCDF file: name in the folder of the scene, or a path")
    ]


class GearDeviationsTable(EccentricTable):
    """Given deviations of a gear, added to those of deviations.seed; deviations.enabled = false ignores them, too."""

    waves: Annotated[tuple[WaveTable, ...], Field(max_length=100, description="waviness")] = ()
    teeth: Annotated[tuple[ToothErrorTable, ...], Field(max_length=1000, description="deviations of single teeth")] = ()
    flanks: Annotated[MeasuredFlanksTable | None, Field(description="measured flanks")] = None

    @model_validator(mode="after")
    def _each_tooth_once(self) -> GearDeviationsTable:
        named = [(error.tooth, error.flank) for error in self.teeth]
        for tooth, flank in named:
            if named.count((tooth, flank)) > 1:
                raise ValueError(f"teeth: tooth {tooth} has two entries for its {flank} flank. Delete one")
        return self

    @property
    def none(self) -> bool:
        """True when nothing is stated."""
        return self == GearDeviationsTable()
