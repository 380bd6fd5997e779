"""`gearcase check`: validate a scene and print what follows from it."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pipelines.plant.plant import Plant
    from pipelines.runs.checked import Checked
    from pipelines.scene.file import LoadedScene


def main(options: argparse.Namespace) -> int:
    """Print ratios, frequencies, torques, cost and warnings; SceneError lists everything that does not fit."""
    from pipelines.border.json_text import json_text
    from pipelines.runs.checked import check_scene
    from pipelines.scene.presets import load_asked

    loaded = load_asked(options)
    found = check_scene(loaded)
    if options.json:
        sys.stdout.write(json_text(_facts(loaded, found)))
        return 0
    sys.stdout.write("".join(f"{line}\n" for line in _lines(found.plant, loaded.scene.control or "none")))
    sys.stdout.write("".join(f"{line}\n" for line in _times(found.plant, loaded.scene.diagnosis.windows_s)))
    sys.stdout.write(f"  {found.cost}\n")
    sys.stdout.write("".join(f"warning: {text}\n" for text in found.warnings))
    return 0


def _facts(loaded: LoadedScene, found: Checked) -> dict[str, Any]:
    """Everything in SI; points of bearings by name."""
    return {
        "scene": loaded.name,
        "title": found.plant.title,
        "control": loaded.scene.control,
        "units": "SI",
        "facts": found.facts,
        "bearings": {f"bearing_{number}": point for number, point in enumerate(found.plant.bearing_points, 1)},
        "models": found.plant.models,
        "faults": found.plant.fault_words,
        "cost": found.cost,
        "warnings": found.warnings,
    }


def _lines(plant: Plant, control: str) -> Iterator[str]:
    from pipelines.plant.casing import ElasticPart

    facts = plant.facts
    yield plant.title
    yield f"  motor speed {facts.motor_speed * 30 / math.pi:.4g} rpm, total ratio {facts.total_ratio:.4f}"
    place = "load" if plant.hoist is None else "drums"
    yield f"  torque at the input {facts.input_torque:.4g} N m, at the {place} {facts.output_torque:.4g} N m"
    if facts.container_speed is not None:
        yield f"  highest container speed {facts.container_speed:.4g} m/s"
    if facts.rope_frequency is not None:
        yield f"  natural frequency of the container on its rope {facts.rope_frequency:.3g} Hz at the start"
    yield (
        "  stage  z1/z2     ratio   a mm      eps_alpha eps_beta  f_m Hz    f_r pinion, wheel Hz  F_bt N   F_bt/b N/mm"
    )
    for number, (pair, stage) in enumerate(zip(plant.layout.pairs, facts.stages, strict=True), 1):
        teeth = f"{pair.pinion.teeth}/{pair.wheel.teeth}"
        yield (
            f"  {number:<6} {teeth:9} {stage.ratio:<7.4f} {stage.centre_distance * 1000:<9.3f} "
            f"{stage.transverse_contact_ratio:<9.4f} {stage.overlap_ratio:<9.4f} {stage.mesh_frequency:<9.5g} "
            f"{stage.pinion_frequency:<9.5g} {stage.wheel_frequency:<10.5g} {stage.mesh_force:<8.4g} "
            f"{stage.line_load / 1000:.4g}"
        )
    for number, point in enumerate(plant.bearing_points, 1):
        x, y, z = (value * 1000 for value in point)
        yield f"  bearing_{number} at x {x:.2f}, y {y:.2f}, z {z:.2f} mm"
    chosen = plant.models
    models = [f"mesh {'/'.join(dict.fromkeys(chosen['mesh']))}"]
    models += [f"casing {chosen['casing']}", f"shafts {chosen['shaft_model']}", f"load {chosen['load']}"]
    yield f"  models: {', '.join(models)}, integrator {chosen['integrator']}"
    if isinstance(plant.casing, ElasticPart) and plant.casing.model.joint is not None:
        from pipelines.plant.casing_parts.joint import joint_words

        yield f"  joint: {joint_words(plant.casing.model.joint, plant.casing.material)}"
    if plant.rolling:
        from pipelines.plant.looked_for import pass_rates

        yield "  rolling bearing    shaft  elements  BPFO Hz   BPFI Hz   BSF Hz    FTF Hz"
        for bearing in plant.rolling:
            rates = "  ".join(f"{value:<8.5g}" for value in pass_rates(plant.layout, bearing).values())
            yield f"  {bearing.name:<18} {bearing.shaft + 1:<6} {bearing.elements.count:<9} {rates}".rstrip()
    if plant.shaft_faults:
        from pipelines.plant.looked_for import shaft_lines

        for fault in plant.shaft_faults:
            wanted = shaft_lines(plant.layout, fault).wanted()
            orders = ", ".join(f"{label} {frequency:.5g} Hz" for label, _, frequency in wanted)
            yield f"  {fault.name}: {orders}"
    if plant.fault_words:
        yield f"  faults: {', '.join(plant.fault_words)}"
    yield f"  control: {control}"


def _times(plant: Plant, windows: Mapping[str, tuple[float, float]]) -> Iterator[str]:
    """How long a window must be for each shaft, and which are too short."""
    from pipelines.features.average import FEWEST_TURNS
    from pipelines.orders.needed_time import needed_seconds
    from pipelines.orders.plant_kinematics import kinematics_of
    from pipelines.signals.spectrum import FEWEST_REVOLUTIONS

    kinematics = kinematics_of(plant.layout, plant.rolling)
    if not kinematics.frequency or not windows:
        return
    uses = {"averages": FEWEST_TURNS, "lines": FEWEST_REVOLUTIONS}
    needed = {use: needed_seconds(kinematics, turns) for use, turns in uses.items()}
    heads = "  ".join(f"{use} ({turns} turns) s" for use, turns in uses.items())
    yield "  shortest window for averages and for spectral lines; windows of the scene that are shorter"
    yield f"  shaft       {heads}  too short"
    for shaft in kinematics.shafts:
        short = []
        for name, (start, end) in windows.items():
            for_what = [use for use in uses if end - start < needed[use][shaft.name]]
            short += [f"{name} ({end - start:.4g} s) for {' and '.join(for_what)}"] if for_what else []
        average, lines = (needed[use][shaft.name] for use in uses)
        yield f"  {shaft.name:<11} {average:<21.4g} {lines:<18.4g} {', '.join(short) or '-'}"
