"""Plan of a run: a scene with faults and its control, for all loads and seeds of the deviations, as one step graph.

The scene and its control are always simulated. With a rope, the equivalent constant torque can also be simulated.
Further seeds and error-free gears show which results depend on the sample of the deviations.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count as count_from
from itertools import islice

from pipelines.engine.step import Graph, Step
from pipelines.engine.storage import digest
from pipelines.io.errors import InputError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.checks.cost import check_room
from pipelines.machine.machine_model import MachineModel, fault_labels
from pipelines.scene.load_scene import LoadedScene, control_differences, control_of
from pipelines.scene.scene import Scene
from pipelines.scene.tables.drive_and_load import LoadModel, StaticTorqueTable
from pipelines.scene.tables.stages import DeviationTable
from pipelines.steps.machine_steps import machine_steps

MOST_DIFFERENCES = 10  # of scene and control that are listed; more belong to another machine
HEALTHY = "healthy "  # prefix of the steps that only a control has


@dataclass(frozen=True, kw_only=True)
class PlannedMotion:
    """A machine, and the name of the step of its motion."""

    machine: MachineModel
    step: str


@dataclass(frozen=True, kw_only=True)
class PlannedCase:
    """A motion of the scene, and that of its healthy control under the same load and deviations; None without one."""

    label: str
    own: PlannedMotion
    control: PlannedMotion | None


@dataclass(frozen=True, kw_only=True)
class RunPlan:
    """All steps and the cases, first that of the scene itself; `baseline` are further healthy machines."""

    graph: Graph
    cases: tuple[PlannedCase, ...]
    control: LoadedScene | None
    baseline: tuple[PlannedMotion, ...] = ()

    @property
    def machine(self) -> MachineModel:
        """The machine of the scene in SI."""
        return self.cases[0].own.machine

    @property
    def machines(self) -> dict[str, MachineModel]:
        """The machine of every motion by the name of its step, first that of the scene, then that of its control."""
        of_cases = [one for case in self.cases for one in (case.own, case.control) if one is not None]
        return {one.step: one.machine for one in (*of_cases, *self.baseline)}

    @property
    def motions(self) -> tuple[str, ...]:
        """Names of the steps of all motions."""
        return tuple(self.machines)


def plan_run(
    loaded: LoadedScene, *, with_control: bool = True, both_loads: bool = True, seeds: int = 0, baseline: int = 0
) -> RunPlan:
    """The steps and cases of a scene.

    Parameters
    ----------
    loaded : the scene
    with_control : simulate the control that the scene names
    both_loads : with a rope and a control, also simulate the equivalent constant torque
    seeds : number of seeds 1, 2, ... of the deviations, to which error-free gears are added; 0: only that of the scene
    baseline : number of healthy machines with other deviations, for comparison in a diagnosis

    Raises
    ------
    SceneError, InputError : a scene or its control cannot be simulated, there is no memory for its signals, or there
        are `seeds` but no control
    """
    control = control_of(loaded) if with_control else None
    if seeds and control is None:
        raise InputError(
            '--seeds: there is no healthy control to compare with. Set control = "without-faults" and a fault, and do '
            "not give --no-control."
        )
    source = loaded.source.shown
    steps: list[Step] = []
    cases: list[PlannedCase] = []

    def added(machine: MachineModel, prefix: str) -> PlannedMotion:
        return PlannedMotion(machine=machine, step=list(add_steps(steps, machine_steps(machine), prefix).values())[-1])

    for label, scene in _variants(loaded.scene, both_loads and control is not None, seeds):
        own = added(checked_machine(scene, source), label)
        healthy = None
        if control is not None:
            like = _like(control.scene, scene, scene.deviations)
            healthy = added(checked_machine(like, control.source.shown), f"{label}{HEALTHY}")
        cases.append(PlannedCase(label=label.strip(), own=own, control=healthy))
    others = [added(machine, f"healthy seed {seed} ") for seed, machine in _baseline(loaded, control, baseline)]
    plan = RunPlan(graph=Graph(steps), cases=tuple(cases), control=control, baseline=tuple(others))
    check_room(tuple(plan.machines.values()), source)
    return plan


def scene_warnings(loaded: LoadedScene, plan: RunPlan, diagnosed: bool = True) -> tuple[str, ...]:
    """What is questionable in a scene, and how its control differs in more than the fault; see `design_warnings`."""
    from pipelines.machine.checks.design_warnings import design_warnings

    warnings = list(design_warnings(loaded.scene, plan.machine, diagnosed))
    if plan.control is not None:
        lines = control_differences(loaded, plan.control)
        head = f"the control {plan.control.name} differs in more than the fault"
        warnings += [f"{head}: {line}" for line in lines[:MOST_DIFFERENCES]]
        if (more := len(lines) - MOST_DIFFERENCES) > 0:
            warnings.append(f'{head}: {more} further values. Set control = "without-faults"')
    return tuple(warnings)


def _baseline(loaded: LoadedScene, control: LoadedScene | None, count: int) -> Iterator[tuple[int, MachineModel]]:
    """Healthy machines with the seeds 1, 2, ... of their deviations, without that of the scene."""
    if not count:
        return
    source = control or loaded
    scene, deviations = source.scene, loaded.scene.deviations
    if not deviations.enabled:
        raise InputError(
            "--baseline: the gears of this scene have no deviations, so healthy machines do not differ. Set "
            "deviations.enabled=true."
        )
    if control is None and fault_labels(scene):
        raise InputError(
            '--baseline: there is no healthy control. Set control = "without-faults", and do not give --no-control.'
        )
    for seed in islice((seed for seed in count_from(1) if seed != deviations.seed), count):
        other = scene.model_copy(update={"deviations": deviations.model_copy(update={"seed": seed})})
        yield seed, checked_machine(_like(other, loaded.scene, other.deviations), source.source.shown)


def _variants(scene: Scene, both_loads: bool, seeds: int) -> list[tuple[str, Scene]]:
    loads = [("", scene)]
    if both_loads and _on_rope(scene.load):
        loads.append(("torque ", scene.model_copy(update={"load": _as_torque(scene.load)})))
    out, given = list(loads), scene.deviations
    own = given.seed if given.enabled else 0
    for name, loaded in loads:
        for seed in (seed for seed in range(seeds + 1 if seeds else 0) if seed != own):  # 0: error-free
            changed = given.model_copy(update={"enabled": seed > 0, "seed": seed or given.seed})
            label = f"{name}seed {seed} " if seed else f"{name}error-free "
            out.append((label, loaded.model_copy(update={"deviations": changed})))
    return out


def _on_rope(load: LoadModel) -> bool:
    return load.model in ("rope", "rope-pendulum")


def _as_torque(rope: LoadModel) -> LoadModel:
    """The weight of the same container as a constant torque."""
    shared = {name: getattr(rope, name) for name in StaticTorqueTable.model_fields if name != "model"}
    return StaticTorqueTable(**shared)


def _like(control: Scene, scene: Scene, deviations: DeviationTable) -> Scene:
    """The control with the load of a variant, and with deviations."""
    if scene.load.model == "static-torque" and _on_rope(control.load):
        control = control.model_copy(update={"load": _as_torque(control.load)})
    return control.model_copy(update={"deviations": deviations})


def add_steps(steps: list[Step], new: list[Step], prefix: str) -> dict[str, str]:
    """Append the steps that are not in the list yet, with a prefix; the new name of each of `new`."""
    known = {_identity(step): step.name for step in steps}
    renamed: dict[str, str] = {}
    for step in new:
        moved = replace(step, takes=step.received(renamed.__getitem__))
        same = known.get(_identity(moved))
        renamed[step.name] = same or f"{prefix}{step.name}"
        if same is None:
            steps.append(replace(moved, name=renamed[step.name]))
    return renamed


def _identity(step: Step) -> tuple:
    return step.kind, step.build, digest(step.spec), digest(step.takes)
