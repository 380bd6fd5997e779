"""Tables of the shafts, what sits on them, and what joins them; their bearings are in `bearings`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, model_validator

from mbd.parts.couplings import CouplingWithAxes, ShaftCoupling
from mbd.parts.load import OutsideForce
from mbd.parts.probe import Probe
from mbd.parts.shafts import Disk, Section, ShaftModel
from pipelines.scene.tables.bearings import BearingModel
from pipelines.scene.tables.derived import DerivedTable, table
from pipelines.scene.tables.scene_table import Flag, Number, Table, Whole


class _OnShaft(DerivedTable):
    """What is on a shaft."""

    shaft: Annotated[Whole, Field(ge=1, description="number of the shaft")]


class EccentricBase(_OnShaft):
    """What a scene gives of a disk besides the disk itself: an unbalance."""

    eccentricity_um: Annotated[
        Number, Field(ge=0, le=1e5, description="distance of its centre of mass from the axis, an unbalance")
    ] = 0.0
    eccentricity_angle_deg: Annotated[
        Number, Field(description="angle of its centre of mass at t = 0, from +x towards +z")
    ] = 0.0

    @model_validator(mode="after")
    def _heavy(self) -> EccentricBase:
        if self.eccentricity_um and not self.mass_kg:
            raise ValueError(
                "eccentricity_um has no effect on a disk with mass_kg = 0. Set mass_kg, or delete eccentricity_um"
            )
        return self

    def unbalances(self, number: int) -> Iterator[OutsideForce]:
        """The unbalance m e of the disk with a number in the scene, if it is eccentric."""
        if self.eccentricity_um:
            from mbd.excitations.unbalance import Unbalance

            yield Unbalance(
                name=f"disk_{number} eccentricity",
                shaft=f"shaft_{self.shaft}",
                y=self.si.position,
                size=self.mass_kg * self.si.eccentricity,
                angle=self.si.eccentricity_angle,
            )


SectionTable: TypeAlias = table(Section)
DiskTable: TypeAlias = table(Disk, EccentricBase)
ProbeTable: TypeAlias = table(Probe, _OnShaft)


class ShaftTable(Table):
    """One shaft with its bearings; shaft 1 is the input."""

    sections: Annotated[
        tuple[SectionTable, ...], Field(min_length=1, description="sections from -y to +y, without gaps")
    ]
    bearing_positions_mm: Annotated[
        tuple[Number, ...],
        Field(
            min_length=1,
            description="y of its bearings, ascending; in a parametric housing within 0.1 mm of the middle of their "
            "bosses",
        ),
    ]
    bearing_supports: Annotated[
        tuple[Literal["casing", "ground"], ...],
        Field(
            description="support of each bearing; empty: the casing for all. An elastic casing supports exactly two "
            "bearings per shaft"
        ),
    ] = ()
    bearings: Annotated[
        tuple[BearingModel, ...], Field(description="one model per bearing; empty: [bearings] for all")
    ] = ()

    @property
    def ends(self) -> tuple[float, float]:
        """y of both ends, m."""
        return self.sections[0].si.start, self.sections[-1].si.end

    @model_validator(mode="after")
    def _joined(self) -> ShaftTable:
        for left, right in zip(self.sections, self.sections[1:], strict=False):
            if left.end_mm != right.start_mm:
                raise ValueError(
                    f"sections must be without gaps, but one ends at {left.end_mm:g} mm and the next starts at "
                    f"{right.start_mm:g} mm. Correct them"
                )
        places, (start, end) = self.bearing_positions_mm, (self.sections[0].start_mm, self.sections[-1].end_mm)
        rising = all(a < b for a, b in zip(places, places[1:], strict=False))
        if not (rising and start <= places[0] and places[-1] <= end):
            raise ValueError(
                f"bearing_positions_mm = {list(places)} must increase, and be on the shaft, {start:g} to {end:g} mm. "
                "Correct them, or make the shaft longer (sections)"
            )
        for key in ("bearing_supports", "bearings"):
            given = getattr(self, key)
            if given and len(given) != len(places):
                raise ValueError(
                    f"{key} has {len(given)} items for {len(places)} bearings. Set one for each, or delete {key}"
                )
        return self


class _ShaftModelBase(DerivedTable):
    """How shafts are modelled."""

    gyroscopic: Annotated[
        Flag, Field(description="true: with gyroscopic moments of shafts and disks at the current speed")
    ] = False


class CouplingBase(DerivedTable):
    """Which shafts a coupling joins."""

    shafts: Annotated[tuple[Whole, Whole], Field(description="numbers of the two shafts")]

    @model_validator(mode="after")
    def _holds(self) -> CouplingBase:
        self.made_part(ShaftCoupling, name="", shafts=("", "other"))  # what it refuses is a problem of the table
        return self

    @property
    def turns_both(self) -> bool:
        """Whether both shafts turn alike."""
        held: float = self.torsional_stiffness_N_m_per_rad
        return held > 0

    def spec(self, number: int) -> ShaftCoupling:
        """The coupling with a number in the scene, in SI; with axes only where these change what it does."""
        placed = {"name": f"coupling_{number}", "shafts": tuple(f"shaft_{shaft}" for shaft in self.shafts)}
        across = self.radial_stiffness_across_N_per_um, self.tilt_stiffness_across_N_m_per_rad
        if not (self.universal_joint or across != (None, None) or any((*self.offset_um, *self.tilt_mrad))):
            return self.made_part(ShaftCoupling, **placed)
        from mbd.excitations.misaligned_coupling import MisalignedCoupling

        return self.made_part(MisalignedCoupling, **placed)


ShaftModelTable: TypeAlias = table(ShaftModel, _ShaftModelBase)
CouplingTable: TypeAlias = table(CouplingWithAxes, CouplingBase)
