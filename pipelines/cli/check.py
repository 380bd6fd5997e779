"""`gearcase check`: validate a scene and print what follows from it."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pipelines.runs.checked import Checked
    from pipelines.scene.file import LoadedScene


def main(options: argparse.Namespace) -> int:
    """Print ratios, frequencies, torques, cost and warnings; SceneError lists everything that does not fit."""
    from pipelines.io.json_text import json_text
    from pipelines.runs.checked import check_scene
    from pipelines.scene.presets import load_asked

    loaded = load_asked(options)
    found = check_scene(loaded)
    if options.json:
        sys.stdout.write(json_text(_facts(loaded, found)))
        return 0
    sys.stdout.write(f"{found}\n")
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
