"""A study: a faulty scene against its control, by load and by deviations, as one graph of stages.

The scene and its control are always run. With the rope, the equivalent constant torque can be run beside it; further
seeds of the deviations and error-free gears tell what belongs to the fault and what to one sample of deviations.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from pipelines.bearings import bearing_frequencies
from pipelines.chain import scene_stages
from pipelines.derived import derive, rope_frequency
from pipelines.diagnosis import DiagnosisSettings
from pipelines.layout import Layout, lay_out
from pipelines.payload import digest
from pipelines.scene import Scene
from pipelines.scene_file import LoadedScene, control_of
from pipelines.stages import Graph, Stage
from pipelines.tables.motion import LoadBase, RopeTable, StaticTorqueTable

HEALTHY = "healthy "  # before the names of a control's own stages


@dataclass(frozen=True, kw_only=True)
class Case:
    """One comparison: `label` "" for the scene itself; names of the stages that hold its two responses."""

    label: str
    scene: Scene
    faulty: str
    healthy: str | None


@dataclass(frozen=True, kw_only=True)
class Study:
    """All stages, and the cases they serve; the first case is the scene itself."""

    graph: Graph
    cases: tuple[Case, ...]
    control: LoadedScene | None

    @property
    def responses(self) -> tuple[str, ...]:
        """Names of all response stages, the scene's own first."""
        names = [name for case in self.cases for name in (case.faulty, case.healthy) if name]
        return tuple(dict.fromkeys(names))


def plan_study(loaded: LoadedScene, *, with_control: bool = True, both_loads: bool = True, seeds: int = 0) -> Study:
    """The stages and cases of a scene.

    Parameters
    ----------
    with_control : run the control that the scene names
    both_loads : with a rope and a control, run the equivalent constant torque as well
    seeds : number of seeds of the deviations 1, 2, ... to compare, and error-free gears; 0 for the scene's own only

    Raises
    ------
    SceneError, InputError : a scene or its control cannot be built
    """
    control = control_of(loaded) if with_control else None
    source = loaded.source.shown
    stages: list[Stage] = []
    cases: list[Case] = []
    for label, scene in _variants(loaded.scene, both_loads and control is not None, seeds if control else 0):
        faulty = list(add_stages(stages, scene_stages(scene, source), label).values())[-1]
        healthy = None
        if control is not None:
            twin = _like(control.scene, scene)
            healthy = list(add_stages(stages, scene_stages(twin, control.source.shown), f"{label}{HEALTHY}").values())[
                -1
            ]
        cases.append(Case(label=label.strip(), scene=scene, faulty=faulty, healthy=healthy))
    return Study(graph=Graph(stages), cases=tuple(cases), control=control)


def _variants(scene: Scene, both_loads: bool, seeds: int) -> list[tuple[str, Scene]]:
    loads = [("", scene)]
    if both_loads and isinstance(scene.load, RopeTable):
        loads.append(("torque ", scene.model_copy(update={"load": _as_torque(scene.load)})))
    out = list(loads)
    for name, loaded in loads:
        for seed in range(seeds + 1 if seeds else 0):
            if seed == scene.deviations.seed and scene.deviations.enabled:
                continue  # the scene itself
            if seed == 0 and not scene.deviations.enabled:
                continue
            enabled = {"enabled": seed > 0, "seed": seed if seed else scene.deviations.seed}
            label = f"{name}seed {seed} " if seed else f"{name}error-free "
            changed = scene.deviations.model_copy(update=enabled)
            out.append((label, loaded.model_copy(update={"deviations": changed})))
    return out


def _as_torque(rope: RopeTable) -> StaticTorqueTable:
    """The weight of the same container as a constant torque."""
    shared = {name: getattr(rope, name) for name in LoadBase.model_fields}
    return StaticTorqueTable(**shared)


def _like(control: Scene, scene: Scene) -> Scene:
    """The control with the load and deviations of a variant."""
    if isinstance(scene.load, StaticTorqueTable) and isinstance(control.load, RopeTable):
        control = control.model_copy(update={"load": _as_torque(control.load)})
    return control.model_copy(update={"deviations": scene.deviations})


def add_stages(stages: list[Stage], new: list[Stage], prefix: str) -> dict[str, str]:
    """Append the stages that are not there yet, renamed; the name under which each of `new` now stands."""
    known = {_identity(stage): stage.name for stage in stages}
    renamed: dict[str, str] = {}
    for stage in new:
        moved = replace(stage, takes=tuple(renamed[name] for name in stage.takes))
        same = known.get(_identity(moved))
        renamed[stage.name] = same or f"{prefix}{stage.name}"
        if same is None:
            stages.append(replace(moved, name=renamed[stage.name]))
    return renamed


def _identity(stage: Stage) -> tuple:
    return stage.kind, stage.build, digest(stage.spec), stage.takes


def diagnosis_settings(scene: Scene, layout: Layout | None = None) -> DiagnosisSettings | None:
    """What the diagnosis of a scene looks for; None if the scene gives no windows or has no sensors."""
    table = scene.diagnosis
    if not table.windows_s or not scene.sensors:
        return None
    layout = layout or lay_out(scene)
    stage = derive(scene, layout).stages[table.stage - 1]
    on_wheel = table.gear == "wheel"
    faulty = Counter((f.stage, f.gear, f.kind) for f in scene.faults)
    words = ", ".join(
        f"{'one tooth' if count == 1 else f'{count} teeth'} of the stage {number} {gear} {kind.removesuffix('-tooth')}"
        for (number, gear, kind), count in faulty.items()
    )
    modes = {
        name: rope_frequency(scene, _rope_length(scene, layout, sum(w) / 2)) for name, w in table.windows_s.items()
    }
    return DiagnosisSettings(
        revolution_frequency=stage.wheel_frequency if on_wheel else stage.pinion_frequency,
        mesh_frequency=stage.mesh_frequency,
        windows=dict(table.windows_s),
        rope_mode={name: value for name, value in modes.items() if value is not None},
        bearings=bearing_frequencies(scene, layout),
        sensor=table.sensor,
        axis=table.axis,
        band=table.envelope_band_Hz,
        shaft=f"shaft_{layout.pair_shafts[table.stage - 1][on_wheel] + 1}",
        fault=words or "no fault",
    )


def _rope_length(scene: Scene, layout: Layout, time: float) -> float | None:
    """Free rope length (m) at a time (s): the length at the start less what the drums have wound."""
    from scipy.integrate import trapezoid

    if not isinstance(scene.load, RopeTable):
        return None
    times, speeds = np.array(scene.drive.times_s), np.array(scene.drive.speeds_rpm) * 2 * np.pi / 60
    fine = np.linspace(0.0, time, 2001)
    angle = float(trapezoid(np.interp(fine, times, speeds), fine)) * layout.shaft_ratios[layout.loaded]
    return scene.load.rope_length_m - angle * scene.load.drum_radius_mm / 1000 / scene.load.reeving_ratio
