"""`gearcase modes`: frequencies, damping and energy shares of small motion about the loaded machine."""

from __future__ import annotations

import argparse
import math
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbd.system.linearised import LinearModes
    from pipelines.io.grid import Grid
    from pipelines.machine.plant import Plant

KINDS = {"shaft": "shafts", "bearing": "bearings", "casing": "casing", "rope": "rope", "drive": "drive"}


def main(options: argparse.Namespace) -> int:
    """Build laws and casing, linearise the machine at rest under its load, print its modes."""
    from pipelines.engine.working import Work
    from pipelines.io.json_text import json_text
    from pipelines.runs.single_results import build_machine_modes, scene_graph
    from pipelines.scene.presets import load_asked

    loaded = load_asked(options)
    modes, cycle = build_machine_modes(
        loaded,
        Work(processes=options.processes, quiet=options.quiet),
        up_to=options.up_to,
        cycle=options.cycle,
        speed=options.speed / 60 * 2 * math.pi,
    )
    _, plant = scene_graph(loaded)
    if options.json:
        found = {
            "scene": loaded.name,
            "cycle": cycle,
            "modes": mode_rows(modes),
            "foot_forces_N": dict(zip(modes.foot_names, modes.foot_forces.tolist(), strict=True)),
            "notes": notes(plant, modes, options.up_to),
        }
        sys.stdout.write(json_text(found))
        return 0
    title = f"{loaded.name}: small vibrations about the loaded static equilibrium, stage 1 at mesh cycle {cycle:.4g}"
    sys.stdout.write(mode_table(title, modes).to_text() + "\n")
    sys.stdout.write("".join(f"{line}\n" for line in notes(plant, modes, options.up_to)))
    return 0


def mode_rows(modes: LinearModes) -> list[dict[str, Any]]:
    """One table per mode: Hz, damping ratio, what makes it, and the share (1) of every part in its energy."""
    return [
        {
            "frequency_Hz": frequency,
            "damping_ratio": damping,
            "dominant": dominant,
            "shares": dict(zip(modes.part_names, shares, strict=True)),
        }
        for frequency, damping, dominant, shares in zip(
            modes.frequencies, modes.damping_ratios, modes.dominant, modes.shares, strict=True
        )
    ]


def mode_table(title: str, modes: LinearModes) -> Grid:
    """One row per mode; shares of its strain and kinetic energy in per cent."""
    from pipelines.report.contents import grid

    columns = {kind: words for kind, words in KINDS.items() if kind in modes.part_kinds}
    columns |= {name: name.replace("_", " ") for name in modes.mesh_names}
    shares = {f"{words} %": 100 * modes.share(part) for part, words in columns.items()}
    rows = [
        {
            "mode": i + 1,
            "frequency Hz": f"{modes.frequencies[i]:.5g}",
            "damping ratio %": 100 * float(modes.damping_ratios[i]),
        }
        | {words: f"{values[i]:.1f}" for words, values in shares.items()}
        | {"dominant": modes.dominant[i]}
        for i in range(len(modes.frequencies))
    ]
    return grid(title, rows)


def notes(plant: Plant, modes: LinearModes, up_to: float) -> list[str]:
    """What the table was made with, and what bounds it."""
    from fem.casing.reduced.body import MODES_OVER_BAND

    found = [
        f"{name.replace('_', ' ')}: force {force:.4g} N, tangent stiffness {stiffness / 1e6:.4g} N/um"
        for name, force, stiffness in zip(modes.mesh_names, modes.mesh_forces, modes.mesh_stiffness, strict=True)
    ]
    found += [
        f"{name.replace('_', ' ')}: force of the ground on the casing ({x:.4g}, {y:.4g}, {z:.4g}) N along x, y, z"
        for name, (x, y, z) in zip(modes.foot_names, modes.foot_forces, strict=True)
    ]
    if modes.overdamped:
        found.append(f"{modes.overdamped} overdamped motions do not oscillate and are not listed.")
    limit = plant.casing.limit
    if limit is not None and limit / MODES_OVER_BAND < up_to:
        found.append(
            f"The casing is resolved to {limit / MODES_OVER_BAND:g} Hz; modes above that are only indicative. "
            "Set a higher casing.band_Hz for them."
        )
    if not len(modes.frequencies):
        found.append(f"No mode up to {up_to:g} Hz; raise --up-to.")
    return found
