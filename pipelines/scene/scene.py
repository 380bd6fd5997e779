"""Scene: the input of a run in units of engineers (suffixes of keys), validated when it is read.

Every class is one TOML table; the tables are in `pipelines.scene.tables` by subject. docs/scene-keys.md is generated
from the descriptions of the fields. Values are kept as written; `pipelines.machine` converts them to SI once.
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, model_validator

from mbd.forces.bearing_models import LinearBearings
from mbd.parts.losses import NoLosses
from pipelines.io.shown_text import shown_value
from pipelines.scene.shaft_places import stage_shafts
from pipelines.scene.tables.bearings import BearingModel
from pipelines.scene.tables.casing import (
    CasingModel,
    MaterialTable,
    SensorTable,
)
from pipelines.scene.tables.derived import table
from pipelines.scene.tables.diagnosis import DiagnosisTable
from pipelines.scene.tables.drive_and_load import DriveModel, LoadModel
from pipelines.scene.tables.faults import SPALL, AnyFaultTable, BearingSpallTable, FaultTable
from pipelines.scene.tables.forces import ForceModel
from pipelines.scene.tables.losses import FilmModel, LossModel, NoFilm
from pipelines.scene.tables.scene_table import Table, repeated_names
from pipelines.scene.tables.shafts import CouplingTable, DiskTable, ProbeTable, ShaftModelTable, ShaftTable
from pipelines.scene.tables.simulation import SimulationTable
from pipelines.scene.tables.stages import DeviationTable, StageTable


class Scene(Table):
    """A gearbox, its drive and load, its faults, and what to compute."""

    title: Annotated[str, Field(max_length=200, description="one line that names the scene in every result")]
    control: Annotated[
        str | None,
        Field(
            description="healthy control, with which the run is compared: a shipped scene, a path that ends "
            'in .toml, or "without-faults": this scene without its faults'
        ),
    ] = None
    gear_material: Annotated[MaterialTable, Field(description="material of all gears and shafts")]
    stages: Annotated[tuple[StageTable, ...], Field(min_length=1, max_length=20, description="gear pairs")]
    shafts: Annotated[
        tuple[ShaftTable, ...], Field(min_length=2, max_length=21, description="shafts; shaft 1 is the input")
    ]
    shaft_model: Annotated[ShaftModelTable, Field(description="how shafts are modelled")] = ShaftModelTable()
    bearings: Annotated[BearingModel, Field(description="model of every bearing for which its shaft gives none")] = (
        table(LinearBearings)()
    )
    couplings: Annotated[
        tuple[CouplingTable, ...], Field(max_length=100, description="couplings and bearings between two shafts")
    ] = ()
    disks: Annotated[tuple[DiskTable, ...], Field(max_length=100, description="disks on shafts")] = ()
    probes: Annotated[tuple[ProbeTable, ...], Field(max_length=100, description="proximity probes")] = ()
    forces: Annotated[
        tuple[ForceModel, ...], Field(max_length=100, description="further forces and torques, besides drive and load")
    ] = ()
    deviations: Annotated[DeviationTable, Field(description="manufacturing deviations of all gears")] = DeviationTable()
    faults: Annotated[tuple[AnyFaultTable, ...], Field(max_length=1000, description="damaged teeth and bearings")] = ()
    casing: Annotated[CasingModel, Field(description="model of the casing")]
    sensors: Annotated[tuple[SensorTable, ...], Field(max_length=1000, description="accelerometers on the casing")] = ()
    drive: Annotated[DriveModel, Field(description="motors, with their speed or torque; default model: speed")]
    load: Annotated[LoadModel, Field(description="what the machine drives")]
    losses: Annotated[LossModel, Field(description="friction")] = table(NoLosses)()
    film: Annotated[FilmModel, Field(description="oil film between the flanks")] = NoFilm()
    simulation: Annotated[SimulationTable, Field(description="time integration and output")]
    diagnosis: Annotated[DiagnosisTable, Field(description="what is diagnosed in the signals")] = DiagnosisTable()

    def models(self) -> dict[str, str | list[str]]:
        """The model that is selected for every effect."""
        chosen = {name: getattr(value, "model", None) for name, value in self}
        found: dict[str, str | list[str]] = {name: model for name, model in chosen.items() if model is not None}
        bearings = (one.model for shaft in self.shafts for one in shaft.bearings or (self.bearings,))
        found["bearings"] = list(dict.fromkeys(bearings))
        return {"mesh": [stage.mesh.model for stage in self.stages], **found, "integrator": self.simulation.integrator}

    @property
    def housing(self) -> Any:
        """The table of the housing; None for a casing without housing."""
        return getattr(self.casing, "housing", None)

    @property
    def parametric(self) -> Any:
        """The table of the housing if that is parametric; None for another."""
        return self.housing if getattr(self.housing, "model", "") == "parametric" else None

    @property
    def tooth_faults(self) -> dict[int, FaultTable]:
        """Faults of teeth by their number in the scene, from 1."""
        return {number: fault for number, fault in enumerate(self.faults, 1) if fault.kind != SPALL}

    @property
    def spalls(self) -> dict[int, BearingSpallTable]:
        """Faults of bearings by their number in the scene, from 1."""
        return {number: fault for number, fault in enumerate(self.faults, 1) if fault.kind == SPALL}

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        problems = list(self._counts()) + list(self._references())
        if problems:
            raise ValueError("\n".join(problems))
        return self

    def _counts(self):
        chain = not self.couplings and all(s.pinion_shaft is None and s.wheel_shaft is None for s in self.stages)
        if chain and len(self.shafts) != len(self.stages) + 1:
            yield (
                f"shafts: {len(self.stages)} stages in a row need {len(self.stages) + 1} shafts, there are "
                f"{len(self.shafts)}. Correct the number of shafts, or set pinion_shaft and wheel_shaft"
            )
        else:
            yield from self._shaft_numbers()
        if self.parametric is not None:
            for key in ("bore_diameters_mm", "boss_diameters_mm"):
                count = len(getattr(self.parametric, key))
                if count != len(self.shafts):
                    yield (
                        f"casing.housing.{key}: number of values {count}, number of shafts {len(self.shafts)}. Set one "
                        "value for each shaft"
                    )
        elif self.sensors and self.housing is None:
            yield (
                f'sensors: {len(self.sensors)} sensors on a casing, but casing.model = "{self.casing.model}". Set '
                "sensors = [], or another casing.model"
            )
        yield from repeated_names("sensors", self.sensors, "Set another name")
        yield from repeated_names("probes", self.probes, "Set another name")

    def _shaft_numbers(self):
        named: list[tuple[str, tuple[int, ...]]] = [
            (f"stages.{n}", pair) for n, pair in enumerate(stage_shafts(self.stages), 1)
        ]
        named += [(f"couplings.{n}.shafts", tuple(s - 1 for s in c.shafts)) for n, c in enumerate(self.couplings, 1)]
        for key, items in (("disks", self.disks), ("probes", self.probes), ("forces", self.forces)):
            named += [(f"{key}.{n}.shaft", (one.shaft - 1,)) for n, one in enumerate(items, 1) if hasattr(one, "shaft")]
        ends = {"drive.shaft": self.drive.shaft or 1, "load.shaft": self.load.shaft or len(self.shafts)}
        named += [(path, (shaft - 1,)) for path, shaft in ends.items()]
        for path, shafts in named:
            for place in shafts:
                if not 0 <= place < len(self.shafts):
                    yield f"{path}: there is no shaft {place + 1}. {_up_to(len(self.shafts))}"
            if len(shafts) == 2 and shafts[0] == shafts[1]:
                yield f"{path}: both ends are on shaft {shafts[0] + 1}. Set two different shafts"
        if self.housing is not None:
            for number, shaft in enumerate(self.shafts, 1):
                carried = len(shaft.bearing_positions_mm) - shaft.bearing_supports.count("ground")
                if carried != 2:
                    yield (
                        f"shafts.{number}: the housing supports {carried} of its bearings, and must support two. "
                        + (
                            'Set two bearing_positions_mm whose bearing_supports is "casing"'
                            if carried < 2
                            else 'Set bearing_supports of the further bearings to "ground"'
                        )
                    )

    def _spalled_bearings(self):
        for number, fault in self.spalls.items():
            if fault.shaft > len(self.shafts):
                yield f"faults.{number}.shaft = {fault.shaft}: there is no such shaft. {_up_to(len(self.shafts))}"
                continue
            shaft = self.shafts[fault.shaft - 1]
            count = len(shaft.bearing_positions_mm)
            if fault.bearing > count:
                yield f"faults.{number}.bearing = {fault.bearing}: there is no such bearing. {_up_to(count)}"
                continue
            bearing = shaft.bearings[fault.bearing - 1] if shaft.bearings else self.bearings
            if bearing.model != "hertz":
                at = f"shafts.{fault.shaft}.bearings.{fault.bearing}" if shaft.bearings else "bearings"
                yield (
                    f"faults.{number}.bearing = {fault.bearing}: bearing {fault.bearing} of shaft {fault.shaft} has "
                    f'the model {bearing.model}, which has no rolling elements. Set {at}.model = "hertz", with a '
                    "designation or the geometry of the bearing"
                )

    def _references(self):
        yield from self._spalled_bearings()
        known = [sensor.name for sensor in self.sensors]
        for number, force in enumerate(self.forces, 1):
            if force.model == "casing-force" and force.point not in known:
                yield (
                    f"forces.{number}.point = {shown_value(force.point)}: a force on the casing acts at a sensor. "
                    + (f"Set one of {', '.join(known)}" if known else "Add a table [[sensors]] of this name")
                )
        for number, fault in self.tooth_faults.items():
            if fault.stage > len(self.stages):
                yield f"faults.{number}.stage = {fault.stage}: there is no such stage. {_up_to(len(self.stages))}"
                continue
            stage = self.stages[fault.stage - 1]
            teeth = stage.pinion_teeth if fault.gear == "pinion" else stage.wheel_teeth
            if fault.tooth is not None and fault.tooth >= teeth:
                yield f"faults.{number}.tooth = {fault.tooth}: the {fault.gear} has {teeth} teeth. Set 0 to {teeth - 1}"
        if self.diagnosis.stage > len(self.stages):
            yield f"diagnosis.stage = {self.diagnosis.stage}: there is no such stage. {_up_to(len(self.stages))}"
        if self.sensors and self.diagnosis.sensor is not None and self.diagnosis.sensor not in known:
            yield (
                f"diagnosis.sensor = {shown_value(self.diagnosis.sensor)}: there is no such sensor. Set one of "
                f"{', '.join(dict.fromkeys(known))}"
            )
        on_teeth = self.tooth_faults.values()
        teeth_hit = [(fault.stage, fault.gear, fault.tooth) for fault in on_teeth if fault.tooth is not None]
        for stage_number, gear, tooth in sorted({hit for hit in teeth_hit if teeth_hit.count(hit) > 1}):
            kinds = [f.kind for f in on_teeth if (f.stage, f.gear, f.tooth) == (stage_number, gear, tooth)]
            if len(set(kinds)) < len(kinds) or "missing-tooth" in kinds:
                yield (
                    f"faults: tooth {tooth} of the stage {stage_number} {gear} has several faults that exclude one "
                    "another. Delete all but one"
                )
        if isinstance(self.diagnosis.envelope_band_Hz, tuple):
            low, high = self.diagnosis.envelope_band_Hz
            if not low < high < self.simulation.output_rate_Hz / 2:
                yield (
                    f"diagnosis.envelope_band_Hz = [{low:g}, {high:g}]: the second frequency must be above the first, "
                    "and "
                    f"below half of simulation.output_rate_Hz, {self.simulation.output_rate_Hz / 2:g} Hz. Correct them"
                )
        for name, (start, end) in self.diagnosis.windows_s.items():
            if not 0 <= start < end:
                yield (
                    f"diagnosis.windows_s.{name} = [{start:g}, {end:g}]: the window must not start before 0, and "
                    "must end after its start. Correct it"
                )
            elif end > self.simulation.end_s:
                yield (
                    f"diagnosis.windows_s.{name} = [{start:g}, {end:g}]: the window ends after simulation.end_s = "
                    f"{self.simulation.end_s:g}. Reduce its end, raise simulation.end_s, or run with --set "
                    "diagnosis.windows_s={} for signals without diagnosis"
                )


def _up_to(count: int) -> str:
    return f"Set 1 to {count}" if count > 1 else "Set 1"
