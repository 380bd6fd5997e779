"""`gearcase modes`: frequencies, damping and energy shares of small motion about the loaded machine."""

from __future__ import annotations

import argparse
import math
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mbd.system.linearised import LinearModes
    from pipelines.border.grid import Grid
    from pipelines.plant.plant import Plant

KINDS = {"shaft": "shafts", "bearing": "bearings", "casing": "casing", "rope": "rope", "drive": "drive"}


def main(options: argparse.Namespace) -> int:
    """Build laws and casing, linearise the machine at rest under its load, print its modes."""
    from mbd.system.linearised import linear_modes, turned
    from mbd.system.system import DEFAULT_BAND
    from pipelines.engine.cache import Cache
    from pipelines.engine.progress import shown_progress
    from pipelines.engine.run_graph import run_graph
    from pipelines.plant.assembly import assemble_machine, assemble_system
    from pipelines.scene.presets import load_asked
    from pipelines.steps.study import plan_study

    loaded = load_asked(options)
    study = plan_study(loaded, with_control=False, both_loads=False)
    graph, plant = study.graph, study.plant
    wanted = [*plant.law_names, "casing"]
    with shown_progress(len(graph.needed(wanted).stages), quiet=options.quiet) as observer:
        outcome = run_graph(graph, Cache(), wanted, observer=observer, processes=options.processes)
    train = assemble_machine(plant.machine, [outcome.value(name) for name in plant.law_names])
    first = train.meshes[0]
    angle = 0.0 if options.cycle is None else (options.cycle - first.cycle_at_start) / first.cycles_per_radian
    train = turned(train, angle)
    band = max(DEFAULT_BAND, 2 * options.up_to)
    system = assemble_system(train, outcome.value("casing"), plant.recorded, band)
    modes = linear_modes(system, up_to=options.up_to, speed=options.speed / 60 * 2 * math.pi)
    cycle = train.meshes[0].cycle_at_start
    title = f"{loaded.name}: small motion about the loaded rest, mesh cycle {cycle:.4g} of stage 1"
    sys.stdout.write(mode_table(title, modes).to_text() + "\n")
    sys.stdout.write("".join(f"{line}\n" for line in notes(plant, modes, options.up_to)))
    return 0


def mode_table(title: str, modes: LinearModes) -> Grid:
    """One row per mode; shares of its strain and kinetic energy in per cent."""
    from pipelines.report.contents import grid

    columns = {kind: words for kind, words in KINDS.items() if kind in modes.part_kinds}
    columns |= {name: name.replace("_", " ") for name in modes.mesh_names}
    shares = {f"{words} %": 100 * modes.share(part) for part, words in columns.items()}
    rows = [
        {"mode": i + 1, "Hz": f"{modes.frequencies[i]:.5g}", "damping %": 100 * float(modes.damping_ratios[i])}
        | {words: f"{values[i]:.1f}" for words, values in shares.items()}
        | {"dominant": modes.dominant[i]}
        for i in range(len(modes.frequencies))
    ]
    return grid(title, rows)


def notes(plant: Plant, modes: LinearModes, up_to: float) -> list[str]:
    """What the table was made with, and what bounds it."""
    from fem.casing.reduced.body import MODES_OVER_BAND
    from pipelines.plant.casing import ElasticPart

    casing = plant.casing
    found = [
        f"{name.replace('_', ' ')}: {force:.4g} N, tangent stiffness {stiffness / 1e6:.4g} N/um"
        for name, force, stiffness in zip(modes.mesh_names, modes.mesh_forces, modes.mesh_stiffness, strict=True)
    ]
    if modes.overdamped:
        found.append(f"{modes.overdamped} overdamped motions do not oscillate and are not listed.")
    limit = casing.model.limit if isinstance(casing, ElasticPart) else None
    if limit is not None and limit / MODES_OVER_BAND < up_to:
        found.append(f"The casing is resolved to {limit / MODES_OVER_BAND:g} Hz; its modes above are indicative only.")
    if not len(modes.frequencies):
        found.append(f"No mode up to {up_to:g} Hz; raise --up-to.")
    return found
