"""What `gearcase check` prints: whether a run accepts a scene, what follows from it, its cost and its warnings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fem.storage import shown_html

if TYPE_CHECKING:
    from pipelines.machine.machine_model import Facts, MachineModel
    from pipelines.scene.load_scene import LoadedScene


@dataclass(frozen=True, kw_only=True, repr=False)
class Checked:
    """A scene that can be run; shown as the text that `gearcase check` prints."""

    machine: MachineModel  # the scene in SI
    facts: Facts  # ratios, frequencies (Hz), speeds (rad/s, m/s), torques (N m), forces (N), lengths (m)
    control: str  # its healthy control, "none" without one
    cost: str  # of a run: steps, seconds, memory, disk
    warnings: tuple[str, ...]  # what is questionable, and how its control differs in more than the fault

    def __repr__(self) -> str:
        own = [*_lines(self.machine, self.control), *_times(self.machine), f"  {self.cost}"]
        return "\n".join([*own, *(f"warning: {text}" for text in self.warnings)])

    def _repr_html_(self) -> str:
        """The gear pairs in numbers, cost and warnings, for a notebook."""
        rows = [
            (
                number,
                f"{pair.pinion.teeth}/{pair.wheel.teeth}",
                stage.ratio,
                stage.mesh_frequency,
                stage.pinion_frequency,
                stage.wheel_frequency,
                stage.mesh_force,
            )
            for number, (pair, stage) in enumerate(zip(self.machine.layout.pairs, self.facts.stages, strict=True), 1)
        ]
        head = ("stage", "z1/z2", "ratio", "mesh, Hz", "pinion, Hz", "wheel, Hz", "mesh force, N")
        text = shown_html.table("Cost and warnings", (), ((line,) for line in (self.cost, *self.warnings)))
        return shown_html.table(self.machine.title, head, rows) + text


def check_scene(loaded: LoadedScene) -> Checked:
    """What a run would refuse is refused here, before anything is computed.

    Raises
    ------
    SceneError, InputError : everything that does not fit
    """
    from pipelines.machine.checks.cost import estimate
    from pipelines.steps.run_plan import plan_run, scene_warnings

    plan = plan_run(loaded)
    return Checked(
        machine=plan.machine,
        facts=plan.machine.facts,
        control=loaded.scene.control or "none",
        cost=estimate(tuple(plan.machines.values())),
        warnings=scene_warnings(loaded, plan),
    )


def _lines(machine: MachineModel, control: str) -> Iterator[str]:
    from fem.gears.sector_mesh import root_chord
    from pipelines.machine.bearing_loads import load_directions

    facts = machine.facts
    yield machine.title
    yield f"  motor speed {facts.motor_speed * 30 / math.pi:.4g} rpm, total ratio {facts.total_ratio:.4f}"
    place = "load" if machine.hoist is None else "drums"
    yield f"  torque at the input {facts.input_torque:.4g} N m, at the {place} {facts.output_torque:.4g} N m"
    if facts.container_speed is not None:
        yield f"  highest container speed {facts.container_speed:.4g} m/s"
    if facts.rope_frequency is not None:
        yield f"  natural frequency of the container on its rope {facts.rope_frequency:.3g} Hz at the start"
    yield "  stage  z1/z2     ratio   a mm      eps_alpha eps_beta  f_m Hz    f_r1 Hz   f_r2 Hz    F_bt N   F_t/b N/mm"
    for number, (pair, stage) in enumerate(zip(machine.layout.pairs, facts.stages, strict=True), 1):
        teeth = f"{pair.pinion.teeth}/{pair.wheel.teeth}"
        yield (
            f"  {number:<6} {teeth:9} {stage.ratio:<7.4f} {stage.centre_distance * 1000:<9.3f} "
            f"{stage.transverse_contact_ratio:<9.4f} {stage.overlap_ratio:<9.4f} {stage.mesh_frequency:<9.5g} "
            f"{stage.pinion_frequency:<9.5g} {stage.wheel_frequency:<10.5g} {stage.mesh_force:<8.4g} "
            f"{stage.line_load / 1000:.4g}"
        )
    for number, pair in enumerate(machine.layout.pairs, 1):
        pinion, wheel = (1000 * root_chord(gear)[1] for gear in (pair.pinion, pair.wheel))
        yield f"  tooth root thickness of stage {number} (for crack depths): pinion {pinion:.4g}, wheel {wheel:.4g} mm"
    directions = load_directions(machine)
    for number, point in enumerate(machine.bearing_points, 1):
        x, y, z = (value * 1000 for value in point)
        angle = directions[f"bearing_{number}"]
        load = "no radial load" if angle is None else f"load at {math.degrees(angle):.0f} deg"
        yield f"  bearing_{number} at x {x:.2f}, y {y:.2f}, z {z:.2f} mm, {load}"
    chosen = machine.models
    models = [f"mesh {'/'.join(dict.fromkeys(chosen['mesh']))}"]
    models += [f"casing {chosen['casing']}", f"shafts {chosen['shaft_model']}", f"load {chosen['load']}"]
    yield f"  models: {', '.join(models)}, integrator {chosen['integrator']}"
    if machine.structure.joint is not None and machine.structure.material is not None:
        from pipelines.machine.joint import joint_words

        yield f"  joint: {joint_words(machine.structure.joint, machine.structure.material)}"
    if machine.rolling:
        from pipelines.machine.scene_kinematics import pass_rates

        yield "  rolling bearing    shaft  elements  BPFO Hz   BPFI Hz   BSF Hz    FTF Hz"
        for bearing in machine.rolling:
            rates = "  ".join(f"{value:<8.5g}" for value in pass_rates(machine.layout, bearing).values())
            yield f"  {bearing.name:<18} {bearing.shaft + 1:<6} {bearing.elements.count:<9} {rates}".rstrip()
    if machine.shaft_faults:
        from pipelines.machine.scene_kinematics import shaft_lines

        for fault in machine.shaft_faults:
            monitored = shaft_lines(machine.layout, fault).monitored()
            orders = ", ".join(f"{label} {frequency:.5g} Hz" for label, _, frequency in monitored)
            yield f"  {fault.name}: {orders}"
    if machine.fault_words:
        yield f"  faults: {', '.join(machine.fault_words)}"
    yield f"  control: {control}"


def _times(machine: MachineModel) -> Iterator[str]:
    """How long a window must be for each shaft, and which are too short."""
    from pipelines.machine.scene_kinematics import kinematics_of
    from pipelines.signals.features.synchronous_averages import FEWEST_TURNS
    from pipelines.signals.orders.kinematics import needed_seconds
    from pipelines.signals.spectrum import FEWEST_REVOLUTIONS

    windows = machine.monitored.windows
    kinematics = kinematics_of(machine.layout, machine.rolling)
    if not kinematics.frequency or not windows:
        return
    uses = {"averages": FEWEST_TURNS, "lines": FEWEST_REVOLUTIONS}
    needed = {use: needed_seconds(kinematics.shafts, kinematics.frequency, turns) for use, turns in uses.items()}
    turns = " and ".join(f"{turns} whole turns for {use}" for use, turns in uses.items())
    yield f"  shortest diagnosis windows: {turns}, and one turn more because a window begins at any angle"
    yield f"  shaft       {'averages s':<11} {'lines s':<11} too short"
    for shaft in kinematics.shafts:
        short = []
        for name, (start, end) in windows.items():
            for_what = [use for use in uses if end - start < needed[use][shaft.name]]
            short += [f"{name} ({end - start:.4g} s) for {' and '.join(for_what)}"] if for_what else []
        average, lines = (needed[use][shaft.name] for use in uses)
        yield f"  {shaft.name:<11} {average:<11.4g} {lines:<11.4g} {', '.join(short) or '-'}"
