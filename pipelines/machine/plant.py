"""Plant: a scene in SI, made once; every step of the pipeline and everything that tells of results takes its parts.

The scene stays what users wrote, in their units; it is read here, and by the checks, and nowhere behind them.
"""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from fem.casing.geometry.dimensions import Sensor
from fem.casing.models.casing import Casing, Structure
from fem.contact.frame import ModelError
from fem.contact.models.mesh_model import LawSpec
from fem.contact.models.registry import loaded_model
from fem.gears.geometry import GeometryError
from mbd.integrators.settings import MotionSettings
from mbd.parts.checks import MachineError
from pipelines.io.errors import Problem, Problems
from pipelines.machine.bearings import BearingFault, RollingBearing, bearing_faults, bearing_points, rolling_bearings
from pipelines.machine.casing import casing
from pipelines.machine.flanks import Fault, flanks_spec, tooth_faults
from pipelines.machine.flanks_spec import FlanksSpec
from pipelines.machine.hoist import Hoist, hoist
from pipelines.machine.layout import Layout, StageFacts, lay_out
from pipelines.machine.looked_for import diagnosis_settings
from pipelines.machine.machine import machine_parts
from pipelines.machine.parts import MachineParts, Recorded
from pipelines.scene.scene import Scene
from pipelines.scene.shaft_faults import ShaftFault, shaft_faults
from pipelines.scene.tables.analysis import LookedFor
from pipelines.scene.tables.casing import FlexibleBase
from pipelines.scene.tables.motion import SpeedDrive
from pipelines.signals.analysis import DiagnosisSettings

REFUSALS = (MachineError, GeometryError, ModelError)


@dataclass(frozen=True, kw_only=True)
class Facts:
    """Derived quantities of a plant (SI)."""

    motor_speed: float
    total_ratio: float
    output_torque: float
    input_torque: float
    stages: tuple[StageFacts, ...]
    rope_frequency: float | None
    container_speed: float | None  # None where nothing is hoisted


@dataclass(frozen=True, eq=False, kw_only=True)
class Drivetrain:
    """Everything but the casing, which may need a file. Tuples `laws` and `flanks` by stage.

    `title`, `labels` (attributes of every response) and `models` (the model of every effect) are words of the scene.
    """

    title: str
    labels: Mapping[str, Any]
    models: Mapping[str, Any]
    layout: Layout
    laws: tuple[LawSpec, ...]
    flanks: tuple[FlanksSpec, ...]
    machine: MachineParts
    hoist: Hoist | None
    rolling: tuple[RollingBearing, ...]
    faults: tuple[Fault, ...]  # of teeth
    spalls: tuple[BearingFault, ...]
    shaft_faults: tuple[ShaftFault, ...]
    bearing_points: tuple[tuple[float, float, float], ...]  # of bearing_1, ..., those that the casing carries (m)
    casing_modes: int  # about as many of the casing add to those of the machine
    recorded: Recorded
    motion: MotionSettings
    looked_for: LookedFor

    @property
    def law_names(self) -> tuple[str, ...]:
        """Names of the steps that hold the mesh laws, by stage."""
        return tuple(f"law_{number}" for number in range(1, len(self.laws) + 1))

    @property
    def sound_law_names(self) -> tuple[str, ...]:
        """Names of the steps that hold the laws of healthy, unmodified pairs, by stage."""
        pairs = zip(self.law_names, self.flanks, strict=True)
        return tuple(name if added.empty else f"healthy_{name}" for name, added in pairs)

    @property
    def facts(self) -> Facts:
        """What follows from it before anything is computed."""
        layout, hoist = self.layout, self.hoist
        drums = layout.motor_speed * layout.shaft_ratios[layout.loaded]
        return Facts(
            motor_speed=layout.motor_speed,
            total_ratio=layout.ratio,
            output_torque=layout.load_torque,
            input_torque=layout.input_torque,
            stages=layout.stages,
            rope_frequency=None if hoist is None else hoist.rope_frequency(),
            container_speed=None if hoist is None else drums * hoist.drum_radius / hoist.reeving,
        )

    @property
    def diagnosis(self) -> DiagnosisSettings | None:
        """What a diagnosis looks for; None without windows or sensors."""
        return diagnosis_settings(
            self.looked_for,
            self.layout,
            self.hoist,
            self.machine.profile,
            self.rolling,
            self.faults,
            self.spalls,
            self.shaft_faults,
        )

    @property
    def fault_words(self) -> tuple[str, ...]:
        """All faults, each with its place: "missing-tooth 0 of the stage 1 wheel"."""
        teeth = (f"{fault.name} of the stage {fault.stage} {fault.gear}" for fault in self.faults)
        return (*teeth, *(fault.name for fault in self.spalls), *(fault.name for fault in self.shaft_faults))

    def faults_of(self, stage: int) -> tuple[Fault, ...]:
        """The faults of a stage (from 1)."""
        return tuple(fault for fault in self.faults if fault.stage == stage)


@dataclass(frozen=True, eq=False, kw_only=True)
class Plant(Drivetrain):
    """The drivetrain in its casing: the model of the casing, and the structure that it reduces, with the sensors."""

    casing: Casing
    structure: Structure

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """The accelerometers on the casing."""
        return self.structure.sensors


def make_plant(scene: Scene, source: str = "scene") -> Plant:
    """The plant of a scene that fits together, see `pipelines.machine.checks.validity.checked_plant`.

    Raises
    ------
    SceneError : all that its parts refuse, at once; `source` names the scene in it
    """
    problems = Problems(*REFUSALS)
    plant = in_casing(drivetrain(scene, lay_out(scene, source), problems), scene, source, problems)
    if plant is None:
        raise problems.error(source)
    return plant


def make_drivetrain(scene: Scene, source: str = "scene") -> Drivetrain:
    """Everything but the casing. SceneError as `make_plant`."""
    problems = Problems(*REFUSALS)
    train = drivetrain(scene, lay_out(scene, source), problems)
    if problems:
        raise problems.error(source)
    return train


def in_casing(train: Drivetrain, scene: Scene, source: str, problems: Problems) -> Plant | None:
    """The drivetrain in its casing; None with any problems.

    Parameters
    ----------
    train, scene : the drivetrain, and the scene that it was made of
    source : of the scene, for messages
    problems : of the drivetrain; take what its mesh laws and its casing refuse
    """
    made = problems.made("casing", casing, scene, train.layout, train.machine, source)
    for number, spec in enumerate(train.laws, 1):
        if reason := _law_refusal(spec):
            problems.append(Problem(f"stages.{number}.mesh", reason))
    return None if problems else Plant(**vars(train), casing=made[0], structure=made[1])


def drivetrain(scene: Scene, layout: Layout, problems: Problems) -> Drivetrain:
    """Everything but the casing; `problems` take what its parts refuse. With any, it is not complete."""
    faults = tooth_faults(scene.tooth_faults.values(), layout.pinion_senses)
    return Drivetrain(
        title=scene.title,
        labels=_labels(scene),
        models=scene.models(),
        layout=layout,
        laws=tuple(law_specs(scene, layout)),
        flanks=tuple(
            flanks_spec(pair, modifications, faults, number)
            for number, (pair, modifications) in enumerate(zip(layout.pairs, layout.modifications, strict=True), 1)
        ),
        machine=machine_parts(scene, layout, faults, problems),
        hoist=hoist(scene.load),
        rolling=() if problems else rolling_bearings(scene),
        faults=faults,
        spalls=tuple(bearing_faults(scene).values()),
        shaft_faults=shaft_faults(scene),
        bearing_points=bearing_points(scene.shafts, layout),
        casing_modes=scene.casing.made_of.added_modes,
        recorded=Recorded(
            sensors=tuple(sensor.name for sensor in scene.sensors),
            journals=not isinstance(scene.casing, FlexibleBase),
        ),
        motion=scene.simulation.made(),
        looked_for=scene.diagnosis.made(
            sensor=scene.diagnosis.sensor or (scene.sensors[0].name if scene.sensors else ""),
            windows=dict(scene.diagnosis.windows_s),
            possible=bool(scene.diagnosis.windows_s and scene.sensors),
            speed_is_known=isinstance(scene.drive, SpeedDrive),
        ),
    )


def law_specs(scene: Scene, layout: Layout) -> list[LawSpec]:
    """The mesh laws that a scene asks for, by stage, before its flanks are modified or damaged."""
    return [
        LawSpec(
            pair=replace(pair, backlash_allowance=0.0),
            mesh=loaded_model(stage.mesh.made(), facts.line_load),
        )
        for stage, pair, facts in zip(scene.stages, layout.pairs, layout.stages, strict=True)
    ]


@functools.lru_cache(maxsize=64)
def _law_refusal(spec: LawSpec) -> str:
    """Why a law cannot be built, by its settings and path of contact; "" where nothing is known against it."""
    try:
        spec.mesh.check(spec.pair)
    except (ModelError, GeometryError) as error:
        return str(error)
    return ""


def fault_labels(scene: Scene) -> list[dict[str, Any]]:
    """Every fault of a scene with its kind, place and severity, in the words of the scene."""
    return [*(fault.model_dump() for fault in scene.faults), *(fault.label for fault in shaft_faults(scene))]


def _labels(scene: Scene) -> dict[str, Any]:
    """What is known of a run without its motion: the attributes that say what was run."""
    deviations, faults = scene.deviations, fault_labels(scene)
    return {
        "title": scene.title,
        "state": "+".join(sorted({fault["kind"] for fault in faults})) or "healthy",
        "load": scene.load.model,
        "faults": json.dumps(faults),
        "seed": deviations.seed if deviations.enabled else "none",
        "iso_grade": deviations.iso_grade if deviations.enabled else "none",
        "sensor_noise_m_s2": scene.diagnosis.noise_m_s2,
        "teeth": json.dumps([[stage.pinion_teeth, stage.wheel_teeth] for stage in scene.stages]),
    }
