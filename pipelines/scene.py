"""Scene: the whole input of a run, as engineers write it (units are key suffixes), validated at the border.

Every class is one TOML table. Field descriptions are the reference for users: docs/scene-keys.md is generated from
them. Values are kept as written; `pipelines.layout` converts them to SI.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

# as written: text is no number, true is not 1
Number = Annotated[float, Field(strict=True)]
Whole = Annotated[int, Field(strict=True)]
Flag = Annotated[bool, Field(strict=True)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
Window = Annotated[tuple[Number, Number], Field(description="start and end in s")]


class Table(BaseModel):
    """Base of all tables: unknown keys, NaN and infinity are refused, values cannot be edited."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class MaterialTable(Table):
    """An isotropic linear elastic material."""

    elastic_modulus_GPa: Annotated[Number, Field(gt=0, le=1e6, description="Young's modulus")]
    poisson_ratio: Annotated[Number, Field(ge=0, lt=0.5, description="Poisson's ratio")]
    density_kg_m3: Annotated[Number, Field(gt=0, description="density")]


class IsoMesh(Table):
    """Mesh stiffness by ISO 6336-1: mean value by formula, shape by contact line length. Milliseconds."""

    model: Literal["iso"] = "iso"
    slices: Annotated[Whole, Field(ge=1, le=101, description="slices along the face")] = 15


class PlaneMesh(Table):
    """Mesh stiffness by 2-D finite elements of the whole ring, sliced along the face. Seconds."""

    model: Literal["plane"] = "plane"
    slices: Annotated[Whole, Field(ge=1, le=101, description="slices along the face")] = 15
    refinement: Annotated[Number, Field(ge=0.5, le=8, description="divides all element sizes of the tooth sector")] = (
        1.0
    )


MeshModel = Annotated[IsoMesh | PlaneMesh, Field(discriminator="model")]


class StageTable(Table):
    """One helical gear pair: the pinion drives (shaft i), the wheel is driven (shaft i + 1)."""

    pinion_teeth: Annotated[Whole, Field(ge=8, le=400, description="z1")]
    wheel_teeth: Annotated[Whole, Field(ge=8, le=400, description="z2")]
    module_mm: Annotated[Number, Field(gt=0, le=60, description="normal module m_n")]
    pressure_angle_deg: Annotated[Number, Field(gt=5, lt=35, description="normal pressure angle alpha_n")] = 20.0
    helix_angle_deg: Annotated[Number, Field(ge=0, le=40, description="helix angle beta at the reference circle")] = 0.0
    pinion_hand: Annotated[Literal["right", "left"], Field(description="hand of the pinion's helix")] = "right"
    face_width_mm: Annotated[Number, Field(gt=0, le=2000, description="common face width b")]
    pinion_profile_shift: Annotated[Number, Field(ge=-1, le=1.5, description="x1")] = 0.0
    wheel_profile_shift: Annotated[Number, Field(ge=-1, le=1.5, description="x2")] = 0.0
    pinion_bore_mm: Annotated[Number, Field(gt=0, description="diameter where the gear body is bonded to the shaft")]
    wheel_bore_mm: Annotated[Number, Field(gt=0, description="diameter where the gear body is bonded to the shaft")]
    rack_addendum: Annotated[Number, Field(gt=0.5, le=1.6, description="in modules")] = 1.0
    rack_dedendum: Annotated[Number, Field(gt=0.8, le=2.0, description="in modules")] = 1.25
    rack_tip_radius: Annotated[Number, Field(gt=0, le=0.5, description="in modules")] = 0.38
    backlash_um: Annotated[Number, Field(ge=0, le=5000, description="transverse backlash along the line of action")] = (
        80
    )
    position_mm: Annotated[Number, Field(description="mid face along the shafts (y)")] = 0.0
    direction_deg: Annotated[
        Number, Field(ge=-180, le=180, description="direction from pinion axis to wheel axis: 0 is +x, 90 is up")
    ] = 0.0
    cycle_at_start: Annotated[Number, Field(ge=0, lt=1, description="mesh cycle c at t = 0, modulo 1")] = 0.0
    mesh_damping_time_us: Annotated[Number, Field(ge=0, le=1000, description="tau_m: damping = tau_m * stiffness")] = (
        1.8
    )
    mesh: MeshModel = PlaneMesh()


class SectionTable(Table):
    """A stretch of a shaft with constant diameters."""

    start_mm: Annotated[Number, Field(description="y of its -y end")]
    end_mm: Annotated[Number, Field(description="y of its +y end")]
    diameter_mm: Annotated[Number, Field(gt=0, description="outer diameter")]
    bore_mm: Annotated[Number, Field(ge=0, description="inner diameter")] = 0.0

    @model_validator(mode="after")
    def _ordered(self) -> SectionTable:
        if self.end_mm <= self.start_mm:
            raise ValueError(f"end_mm = {self.end_mm} must be greater than start_mm = {self.start_mm}")
        if self.bore_mm >= self.diameter_mm:
            raise ValueError(f"bore_mm = {self.bore_mm} must be smaller than diameter_mm = {self.diameter_mm}")
        return self


class ShaftTable(Table):
    """One shaft; shaft 1 is the input."""

    sections: Annotated[tuple[SectionTable, ...], Field(min_length=1, description="from -y to +y, without gaps")]
    bearing_positions_mm: Annotated[tuple[Number, Number], Field(description="y of its two bearings, -y first")]

    @model_validator(mode="after")
    def _joined(self) -> ShaftTable:
        for left, right in zip(self.sections, self.sections[1:], strict=False):
            if left.end_mm != right.start_mm:
                raise ValueError(f"sections: one ends at {left.end_mm} mm, the next starts at {right.start_mm} mm")
        first, last = self.bearing_positions_mm
        if not self.sections[0].start_mm <= first < last <= self.sections[-1].end_mm:
            raise ValueError(
                f"bearing_positions_mm = {[first, last]} must rise and lie between {self.sections[0].start_mm} and "
                f"{self.sections[-1].end_mm} mm"
            )
        return self


class ShaftModel(Table):
    """How shafts are modelled."""

    model: Annotated[
        Literal["torsion", "timoshenko"], Field(description="torsion: rigid but in twist; timoshenko: beam elements")
    ] = "timoshenko"
    element_length_mm: Annotated[Number, Field(gt=0, description="longest beam element")] = 40.0
    damping_time_us: Annotated[Number, Field(ge=0, le=1000, description="material damping = this time * stiffness")] = (
        0.5
    )


class BearingTable(Table):
    """Linear bearings between shaft and casing, the same for all."""

    model: Literal["linear"] = "linear"
    radial_stiffness_N_per_um: Annotated[Number, Field(ge=0.01, le=1e6, description="in x and z")] = 100.0
    axial_stiffness_N_per_um: Annotated[Number, Field(ge=0.01, le=1e6, description="along the shaft")] = 50.0
    tilt_stiffness_N_m_per_rad: Annotated[Number, Field(ge=0, le=1e9, description="about x and z")] = 1.0e4
    damping_time_us: Annotated[Number, Field(ge=0, le=1e4, description="damping = this time * stiffness")] = 5.0


class DeviationTable(Table):
    """Seeded cumulative pitch deviations of every tooth within the tolerances of ISO 1328-1."""

    enabled: Annotated[Flag, Field(description="false: error-free gears")] = True
    iso_grade: Annotated[Whole, Field(ge=1, le=11, description="flank tolerance class of ISO 1328-1:2013")] = 5
    seed: Annotated[Whole, Field(ge=0, le=2**31, description="same seed, same deviations")] = 1


class FaultTable(Table):
    """One damaged tooth."""

    kind: Annotated[Literal["missing-tooth"], Field(description="what is wrong with the tooth")]
    stage: Annotated[Whole, Field(ge=1, description="number of the stage")]
    gear: Annotated[Literal["pinion", "wheel"], Field(description="gear of that stage")]
    tooth: Annotated[Whole, Field(ge=0, description="number of the tooth; 0 is in contact at the pitch point at c = 0")]


class HousingTable(Table):
    """The parametric housing: a closed box with bearing bosses in its two side walls and six feet."""

    length_mm: Annotated[Number, Field(gt=0, description="outer length along x")]
    width_mm: Annotated[Number, Field(gt=0, description="outer width along y; mid face is y = 0")]
    height_mm: Annotated[Number, Field(gt=0, description="outer height along z without feet")]
    wall_thickness_mm: Annotated[Number, Field(gt=0, description="of all walls, floor and cover")]
    left_end_mm: Annotated[Number, Field(description="x of the outer face of the left end wall; shaft 1 is x = 0")]
    shaft_height_mm: Annotated[Number, Field(gt=0, description="shaft 1 above the underside of the floor")]
    bore_diameters_mm: Annotated[tuple[Positive, ...], Field(description="one per shaft, for both of its bearings")]
    boss_diameters_mm: Annotated[tuple[Positive, ...], Field(description="one per shaft")]
    boss_length_mm: Annotated[Number, Field(gt=0, description="along y, from the outer wall face inwards")]
    foot_length_mm: Annotated[Number, Field(gt=0, description="side of the square foot pads")] = 60.0
    foot_height_mm: Annotated[Number, Field(gt=0, description="foot pads below the floor")] = 15.0


class NoCasingTable(Table):
    """Bearings to ground. Casing sensors are refused; channels are bearing forces and shaft motion."""

    model: Literal["none"] = "none"


class FlexibleBase(Table):
    """What every casing with a housing has."""

    housing: HousingTable
    material: MaterialTable
    damping_ratio: Annotated[Number, Field(ge=0, lt=1, description="modal damping")] = 0.01


class RigidCasingTable(FlexibleBase):
    """A rigid body on six mount springs, one per foot: 6 coordinates, no finite elements."""

    model: Literal["rigid"] = "rigid"
    mount_stiffness_N_per_um: Annotated[Number, Field(gt=0, le=1e7, description="of each foot, in x, y and z")] = 200.0


class StaticCasingTable(FlexibleBase):
    """Finite elements condensed statically (Guyan) to the bearing points."""

    model: Literal["static"] = "static"
    element_size_mm: Annotated[Number, Field(gt=0, description="of the tetrahedra")] = 22.0


class CraigBamptonCasingTable(FlexibleBase):
    """Finite elements reduced to the bearing points and the fixed-interface modes."""

    model: Literal["craig-bampton"] = "craig-bampton"
    element_size_mm: Annotated[Number, Field(gt=0, description="of the tetrahedra")] = 22.0
    band_Hz: Annotated[Number, Field(gt=0, le=20000, description="wanted band; modes are kept to 1.5 times it")] = (
        5000.0
    )


CasingModel = Annotated[
    NoCasingTable | RigidCasingTable | StaticCasingTable | CraigBamptonCasingTable, Field(discriminator="model")
]


class SensorTable(Table):
    """A tri-axial accelerometer on the casing."""

    name: Annotated[str, Field(pattern=r"^sensor_[1-9][0-9]*$", description="sensor_1, sensor_2, ...")]
    position_mm: Annotated[
        tuple[Number, Number, Number], Field(description="x, y, z; moved to the nearest surface point")
    ]


class DriveTable(Table):
    """Speed-driven motors at both ends of shaft 1, each through a coupling that only holds the rotation."""

    times_s: Annotated[tuple[Number, ...], Field(min_length=2, description="strictly rising, starting at 0")]
    speeds_rpm: Annotated[tuple[Number, ...], Field(min_length=2, description="motor speed at these times")]
    motors: Annotated[Literal[1, 2], Field(description="2: one at each end; 1: at the -y end")] = 2
    coupling_stiffness_N_m_per_rad: Annotated[Number, Field(gt=0, description="of each coupling")] = 2000.0
    coupling_damping_N_m_s_per_rad: Annotated[Number, Field(ge=0, description="of each coupling")] = 0.5

    @model_validator(mode="after")
    def _table(self) -> DriveTable:
        if len(self.times_s) != len(self.speeds_rpm):
            raise ValueError(f"times_s has {len(self.times_s)} values, speeds_rpm has {len(self.speeds_rpm)}")
        if self.times_s[0] != 0:
            raise ValueError(f"times_s must start at 0, it starts at {self.times_s[0]}")
        for before, after in zip(self.times_s, self.times_s[1:], strict=False):
            if after <= before:
                raise ValueError(f"times_s must rise strictly: {after} s follows {before} s")
        return self


class LoadBase(Table):
    """What every load has: a weight on two drums."""

    container_kg: Annotated[Number, Field(ge=0, description="hanging mass")]
    drum_radius_mm: Annotated[Number, Field(gt=0, description="to the middle of the rope")]
    drum_mass_kg: Annotated[Number, Field(gt=0, description="of each drum, overhung at the ends of the last shaft")]
    drum_inertia_kg_m2: Annotated[Number, Field(gt=0, description="of each drum about the shaft")]
    reeving_ratio: Annotated[Number, Field(gt=0, description="rope speed at the drum over container speed")] = 2.0


class StaticTorqueTable(LoadBase):
    """The weight as a constant torque on the drums."""

    model: Literal["static-torque"] = "static-torque"


class RopeTable(LoadBase):
    """Container on elastic rope: stiffness of the current length, tension only."""

    model: Literal["rope"] = "rope"
    rope_diameter_mm: Annotated[Number, Field(gt=0, description="nominal diameter")] = 10.0
    rope_modulus_GPa: Annotated[Number, Field(gt=0, description="on the metallic area")] = 100.0
    rope_fill_factor: Annotated[Number, Field(gt=0, le=1, description="metallic area over the circle")] = 0.455
    rope_falls: Annotated[Whole, Field(ge=1, description="falls that carry the container")] = 8
    rope_length_m: Annotated[Number, Field(gt=0, description="free length at t = 0")] = 5.0
    rope_damping_ratio: Annotated[Number, Field(ge=0, lt=1, description="of the bounce at the initial length")] = 0.02


LoadModel = Annotated[StaticTorqueTable | RopeTable, Field(discriminator="model")]


class SimulationTable(Table):
    """Time integration and output."""

    end_s: Annotated[Number, Field(gt=0, le=3600, description="simulated time")]
    output_rate_Hz: Annotated[Number, Field(gt=0, le=200000, description="after the anti-alias filter")] = 10000.0
    step_us: Annotated[Number, Field(gt=0, le=1000, description="rounded down to a whole part of the output step")] = (
        10.0
    )
    integrator: Annotated[
        Literal["exponential", "trapezoidal", "generalised-alpha"], Field(description="see docs/choosing-a-rung.md")
    ] = "exponential"


class DiagnosisTable(Table):
    """What the spectra and the envelope table look at."""

    sensor: Annotated[str, Field(description="its signal is diagnosed")] = "sensor_3"
    axis: Annotated[Literal["x", "y", "z", "resultant"], Field(description="of the sensor")] = "z"
    stage: Annotated[Whole, Field(ge=1, description="stage whose mesh frequency carries the sidebands")] = 1
    gear: Annotated[Literal["pinion", "wheel"], Field(description="gear whose rotation is sought")] = "wheel"
    windows_s: dict[str, Window] = Field(default_factory=dict, description="constant-speed windows by name")
    envelope_band_Hz: Annotated[
        Literal["mesh", "resonance"] | tuple[Positive, Positive],
        Field(
            description="band that is demodulated, [low, high]; mesh: f_m / 2 around f_m; resonance: where the healthy "
            "run is strongest"
        ),
    ] = "mesh"
    noise_m_s2: Annotated[Number, Field(ge=0, description="rms of white sensor noise added before diagnosis")] = 0.01


class Scene(Table):
    """A gearbox, its drive and load, its faults, and what to compute."""

    title: Annotated[str, Field(description="one line that names the scene in every result")]
    control: Annotated[
        str | None, Field(description='healthy twin: a shipped scene, a path ending in .toml, or "without-faults"')
    ] = None
    gear_material: MaterialTable
    stages: Annotated[tuple[StageTable, ...], Field(min_length=1, max_length=6)]
    shafts: Annotated[tuple[ShaftTable, ...], Field(min_length=2, max_length=7)]
    shaft_model: ShaftModel = ShaftModel()
    bearings: BearingTable = BearingTable()
    deviations: DeviationTable = DeviationTable()
    faults: tuple[FaultTable, ...] = ()
    casing: CasingModel
    sensors: tuple[SensorTable, ...] = ()
    drive: DriveTable
    load: LoadModel
    simulation: SimulationTable
    diagnosis: DiagnosisTable = DiagnosisTable()

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        problems = list(self._counts()) + list(self._references())
        if problems:
            raise ValueError("\n".join(problems))
        return self

    def _counts(self):
        if len(self.shafts) != len(self.stages) + 1:
            yield f"shafts: {len(self.shafts)} given, {len(self.stages)} stages need {len(self.stages) + 1}"
        if isinstance(self.casing, FlexibleBase):
            for key in ("bore_diameters_mm", "boss_diameters_mm"):
                count = len(getattr(self.casing.housing, key))
                if count != len(self.shafts):
                    yield f"casing.housing.{key}: {count} values for {len(self.shafts)} shafts"
        elif self.sensors:
            yield (
                f"sensors: {len(self.sensors)} casing sensors with casing.model = 'none'. Give sensors = [] or another "
                "casing model"
            )
        names = [sensor.name for sensor in self.sensors]
        for name in sorted({n for n in names if names.count(n) > 1}):
            yield f"sensors: {name} is given {names.count(name)} times"

    def _references(self):
        for number, fault in enumerate(self.faults, 1):
            if fault.stage > len(self.stages):
                yield f"faults.{number}.stage = {fault.stage}: there are {len(self.stages)} stages"
                continue
            stage = self.stages[fault.stage - 1]
            teeth = stage.pinion_teeth if fault.gear == "pinion" else stage.wheel_teeth
            if fault.tooth >= teeth:
                yield f"faults.{number}.tooth = {fault.tooth}: the {fault.gear} has teeth 0 to {teeth - 1}"
        if self.diagnosis.stage > len(self.stages):
            yield f"diagnosis.stage = {self.diagnosis.stage}: there are {len(self.stages)} stages"
        if self.sensors and self.diagnosis.sensor not in {sensor.name for sensor in self.sensors}:
            yield f"diagnosis.sensor = {self.diagnosis.sensor!r}: not among the sensors of the scene"
        teeth_hit = [(fault.stage, fault.gear, fault.tooth) for fault in self.faults]
        for stage_number, gear, tooth in sorted({hit for hit in teeth_hit if teeth_hit.count(hit) > 1}):
            yield f"faults: tooth {tooth} of the stage {stage_number} {gear} is given more than once"
        if isinstance(self.diagnosis.envelope_band_Hz, tuple):
            low, high = self.diagnosis.envelope_band_Hz
            if not low < high < self.simulation.output_rate_Hz / 2:
                yield (
                    f"diagnosis.envelope_band_Hz = [{low:g}, {high:g}]: must rise and end below half of "
                    f"simulation.output_rate_Hz, {self.simulation.output_rate_Hz / 2:g} Hz"
                )
        for name, (start, end) in self.diagnosis.windows_s.items():
            if not 0 <= start < end:
                yield f"diagnosis.windows_s.{name} = [{start}, {end}]: must start at or after 0 and end later"
            elif end > self.simulation.end_s:
                yield f"diagnosis.windows_s.{name} ends at {end} s, after simulation.end_s = {self.simulation.end_s} s"
