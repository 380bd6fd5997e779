"""Tables of one gear beyond the data of its stage: rack, tip, thickness, body, and modifications of its flanks."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import Field, model_validator

from fem.gears.gear import GearDetails
from fem.gears.modifications import FlankModifications
from fem.gears.prescribed import Eccentricity, ToothError, Wave
from pipelines.scene.tables.derived import DerivedTable, table
from pipelines.scene.tables.scene_table import Number, Table

EccentricTable: Any = table(Eccentricity)
WaveTable: TypeAlias = table(Wave)
ToothErrorTable: TypeAlias = table(ToothError)


class MeasuredFlanksTable(Table):
    """Deviations at points of the flanks, as from a gear measuring machine: see docs/flank-deviations.md."""

    file: Annotated[
        str, Field(min_length=1, description="CSV or netCDF file: name in the folder of the scene, or a path")
    ]


class GearDeviationsTable(EccentricTable):
    """Given deviations of a gear, added to the random ones; deviations.enabled = false disables both."""

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


Micrometres = Annotated[Number, Field(ge=-1000, le=1000)]


class _RackBase(DerivedTable):
    """The basic rack of one gear."""

    rack_addendum: Annotated[
        Number | None,
        Field(gt=0.3, le=2, description="addendum of the basic rack divided by module; without it: that of the stage"),
    ] = None
    rack_dedendum: Annotated[
        Number | None,
        Field(
            gt=0.3, le=2.5, description="dedendum of the basic rack divided by module; without it: that of the stage"
        ),
    ] = None
    rack_tip_radius: Annotated[
        Number | None,
        Field(
            ge=0,
            le=1,
            description="tip radius of the basic rack divided by module, which forms the root fillet; without it: that "
            "of the stage",
        ),
    ] = None


_Gear: Any = table(FlankModifications, table(GearDetails, _RackBase))


class GearTable(_Gear):
    """Details of the pinion or wheel of a stage. Modifications are on both flanks of every tooth."""

    deviations: Annotated[GearDeviationsTable, Field(description="deviations that are given instead of sampled")] = (
        GearDeviationsTable()
    )


class MisalignmentTable(Table):
    """Misalignment of the axes over the face width, without load."""

    in_plane_um: Annotated[
        Micrometres, Field(description="in-plane deviation f_sigma_delta: growth of the centre distance towards +y")
    ] = 0.0
    out_of_plane_um: Annotated[
        Micrometres,
        Field(
            description="out-of-plane deviation f_sigma_beta, times cos alpha_wt along the line of action; positive "
            "opens the drive flanks at the +y end"
        ),
    ] = 0.0
