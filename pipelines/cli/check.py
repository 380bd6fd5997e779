"""`gearcase check`: validate a scene and print what follows from it."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from pipelines.cli.command_line import JSON, SCENE

if TYPE_CHECKING:
    from pipelines.runs.checked_scene import Checked
    from pipelines.scene.load_scene import LoadedScene

ARGUMENTS = (
    *SCENE,
    JSON,
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Check a scene file. Print ratios, frequencies, tooth forces, bearing positions, the shortest usable time windows,
    and time, memory and disk space of a run. Nothing is simulated and no file is written. Takes seconds.

    Symbols: a centre distance; eps_alpha, eps_beta transverse contact ratio and overlap ratio; f_m mesh frequency;
    f_r1, f_r2 revolution frequencies of pinion and wheel; F_bt force on the transverse line of action; F_t/b
    tangential force per face width.

    Example
    -------
    gearcase check rig-missing-tooth
    Quay-crane hoist rig, one tooth of the stage 1 wheel missing, container on rope
    ...
      control: rig-healthy
    ...
    """
    from pipelines.io.json_text import json_text
    from pipelines.runs.checked_scene import check_scene
    from pipelines.scene.presets import load_requested

    loaded = load_requested(options)
    found = check_scene(loaded)
    yield json_text(_facts(loaded, found)) if options.json else str(found)


def _facts(loaded: LoadedScene, found: Checked) -> dict[str, Any]:
    """Everything in SI; points of bearings by name."""
    return {
        "scene": loaded.name,
        "title": found.machine.title,
        "control": loaded.scene.control,
        "units": "SI",
        "facts": found.facts,
        "bearings": {f"bearing_{number}": point for number, point in enumerate(found.machine.bearing_points, 1)},
        "models": found.machine.models,
        "faults": found.machine.fault_words,
        "cost": found.cost,
        "warnings": found.warnings,
    }
