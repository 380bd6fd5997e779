"""`gearcase gears`: the mesh laws of a scene."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pipelines.runs.gear_numbers import MeshState
    from pipelines.steps.pair_curves import PairLaws


def main(options: argparse.Namespace) -> int:
    """Build the laws; print stiffness, transmission error, share and pressure of each pair, healthy and faulty."""
    from pipelines.border.errors import InputError
    from pipelines.border.json_text import json_text
    from pipelines.engine.working import Work
    from pipelines.report.contents import grid
    from pipelines.runs.gear_numbers import (
        checked_curve_file,
        gear_curves,
        gear_rows,
        machine_states,
        write_curves,
    )
    from pipelines.runs.single_results import build_pairs
    from pipelines.scene.presets import load_asked

    target = None if options.out is None else checked_curve_file(options.out)
    if options.tilt == "machine" and options.load is not None:
        raise InputError("--tilt machine: the load is that of the machine; leave --load out, or give the tilt in um.")
    loaded, work = load_asked(options), Work(processes=options.processes, quiet=options.quiet)
    pairs = build_pairs(loaded, work)
    states = machine_states(loaded, work) if options.tilt == "machine" else _states(pairs, options)
    curves = gear_curves(pairs, states)
    rows = gear_rows(pairs, curves)
    if target is not None:
        write_curves(curves, target)
    if options.json:
        sys.stdout.write(json_text({"pairs": rows, "notes": notes(pairs, states), "curves": target}))
        return 0
    title = "Drive flanks without deviations, along the transverse line of action, compliance counted from the bores"
    sys.stdout.write(grid(title, rows).to_text() + "\n")
    sys.stdout.write("".join(f"{line}\n" for line in notes(pairs, states)))
    if target is not None:
        sys.stdout.write(f"{target}\n")
    return 0


def _states(pairs: Sequence[PairLaws], options: argparse.Namespace) -> list[MeshState]:
    from pipelines.runs.gear_numbers import MeshState

    load, tilt = options.load, options.tilt
    return [
        MeshState(
            force=found.force if load is None else load,
            tilt=None if tilt == "balanced" else found.sense * tilt * 1e-6 / found.pair.face_width,
        )
        for found in pairs
    ]


def notes(pairs: Sequence[PairLaws], states: Sequence[MeshState]) -> list[str]:
    """What the table was made with, and how its columns are meant."""
    found = []
    for pair, state in zip(pairs, states, strict=True):
        gears, width = pair.pair, pair.pair.face_width
        tilt = "force at mid face" if state.tilt is None else f"tilt {1e6 * pair.sense * state.tilt * width:.3g} um"
        found.append(
            f"stage {pair.stage}: model {pair.drive.model}, eps_alpha {gears.transverse_contact_ratio:.4g}, eps_beta "
            f"{gears.overlap_ratio:.4g}, bores {2000 * gears.pinion.bore_radius:g}/{2000 * gears.wheel.bore_radius:g} "
            f"mm, {tilt} over the face"
        )
    found.append(
        "Means, least stiffness and peak-to-peak over the whole pitches in which the tooth is in mesh; at: mesh cycles "
        "from its contact at the pitch point; share and pressure: greatest of its tooth pair."
    )
    return found
