"""Machine model of a scene in SI units, the input of all steps and reports.

The scene keeps the values and units of its file. Only the modules that make or check the machine model read it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fem.casing.geometry.dimensions import Sensor
from fem.casing.models.casing_model import CasingModel, Structure
from fem.contact.models.mesh_model import LawSpec
from mbd.forces.hanging_loads import HangingLoad
from mbd.integrators.settings import MotionSettings
from pipelines.machine.flanks_spec import FlanksSpec
from pipelines.machine.layout import StageFacts, TrainLayout
from pipelines.machine.machine_parts import MachineParts, Recorded
from pipelines.machine.scene_bearings import BearingFault, RollingBearing
from pipelines.machine.scene_flanks import Fault
from pipelines.machine.scene_kinematics import pass_lines, pass_rates, shaft_lines
from pipelines.scene.scene import Scene
from pipelines.scene.shaft_faults import ShaftFault, shaft_faults
from pipelines.scene.tables.diagnosis import Monitored
from pipelines.signals.analysis import DiagnosisSettings


@dataclass(frozen=True, kw_only=True)
class Facts:
    """Derived quantities of a machine (SI)."""

    motor_speed: float
    total_ratio: float
    output_torque: float
    input_torque: float
    stages: tuple[StageFacts, ...]
    rope_frequency: float | None
    container_speed: float | None  # None where nothing is hoisted


@dataclass(frozen=True, eq=False, kw_only=True)
class Drivetrain:
    """The machine model without the casing, which may need a file.

    `laws` and `flanks` are ordered by stage. `title`, `labels` (attributes of every response) and `models` (the model
    of each effect) are taken from the scene.
    """

    title: str
    labels: Mapping[str, Any]
    models: Mapping[str, Any]
    layout: TrainLayout
    laws: tuple[LawSpec, ...]
    flanks: tuple[FlanksSpec, ...]
    parts: MachineParts
    hoist: HangingLoad | None
    rolling: tuple[RollingBearing, ...]
    faults: tuple[Fault, ...]  # of teeth
    spalls: tuple[BearingFault, ...]
    shaft_faults: tuple[ShaftFault, ...]
    bearing_points: tuple[tuple[float, float, float], ...]  # of bearing_1, ..., those that the casing carries (m)
    casing_modes: int  # approximate number of casing modes in the system
    recorded: Recorded
    motion: MotionSettings
    monitored: Monitored

    @property
    def law_names(self) -> tuple[str, ...]:
        """Names of the steps that hold the mesh laws, by stage."""
        return tuple(f"law_{number}" for number in range(1, len(self.laws) + 1))

    @property
    def healthy_law_names(self) -> tuple[str, ...]:
        """Names of the steps that hold the laws of healthy, unmodified pairs, by stage."""
        pairs = zip(self.law_names, self.flanks, strict=True)
        return tuple(name if added.empty else f"unmodified_{name}" for name, added in pairs)

    @property
    def facts(self) -> Facts:
        """Quantities that follow from the scene without a computation."""
        layout, hoist = self.layout, self.hoist
        drums = layout.motor_speed * layout.shaft_ratios[layout.loaded]
        return Facts(
            motor_speed=layout.motor_speed,
            total_ratio=layout.ratio,
            output_torque=layout.load_torque,
            input_torque=layout.input_torque,
            stages=layout.stages,
            rope_frequency=None if hoist is None else hoist.rope_frequency(),
            container_speed=None if hoist is None else drums * hoist.drum_radius / hoist.reeving_ratio,
        )

    @property
    def diagnosis(self) -> DiagnosisSettings | None:
        """Signal, lines and windows of a diagnosis; None without windows or sensors, or at rest."""
        monitored, layout, hoist = self.monitored, self.layout, self.hoist
        if not monitored.possible or layout.turns == 0.0:
            return None
        stage = layout.stages[monitored.stage - 1]
        on_wheel = monitored.gear == "wheel"
        ratio = layout.shaft_ratios[layout.loaded]
        modes = {
            name: hoist.rope_frequency_at(sum(window) / 2, self.parts.profile, ratio)
            for name, window in monitored.windows.items()
            if hoist is not None and monitored.speed_is_known
        }
        return DiagnosisSettings(
            revolution_frequency=stage.wheel_frequency if on_wheel else stage.pinion_frequency,
            mesh_frequency=stage.mesh_frequency,
            windows=monitored.windows,
            rope_mode={name: value for name, value in modes.items() if value is not None},
            bearings={f"{one.name} {key}": f for one in self.rolling for key, f in pass_rates(layout, one).items()},
            passes=tuple(dict.fromkeys(pass_lines(layout, self.rolling, fault) for fault in self.spalls)),
            turning=tuple(shaft_lines(layout, fault) for fault in self.shaft_faults),
            sensor=monitored.sensor or "",
            axis=monitored.axis,
            band=monitored.band,
            shaft=f"shaft_{layout.pair_shafts[monitored.stage - 1][on_wheel] + 1}",
            speed_is_known=monitored.speed_is_known,
        )

    @property
    def fault_words(self) -> tuple[str, ...]:
        """Description of each fault with its place, such as "missing-tooth 0 of the stage 1 wheel"."""
        teeth = (f"{fault.name} of the stage {fault.stage} {fault.gear}" for fault in self.faults)
        return (*teeth, *(fault.name for fault in self.spalls), *(fault.name for fault in self.shaft_faults))

    def faults_of(self, stage: int) -> tuple[Fault, ...]:
        """The faults of a stage (from 1)."""
        return tuple(fault for fault in self.faults if fault.stage == stage)


@dataclass(frozen=True, eq=False, kw_only=True)
class MachineModel(Drivetrain):
    """The machine model with its casing: the model of the casing, and the structure with sensors that it reduces."""

    casing: CasingModel
    structure: Structure

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """The accelerometers on the casing."""
        return self.structure.sensors


def fault_labels(scene: Scene) -> list[dict[str, Any]]:
    """Every fault of a scene with its kind, place and severity, by the keys of the scene."""
    return [*(fault.model_dump() for fault in scene.faults), *(fault.label for fault in shaft_faults(scene))]


def labels(scene: Scene) -> dict[str, Any]:
    """Attributes of a response that describe the simulated machine."""
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
