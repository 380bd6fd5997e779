"""Teeth of a scene: clearances by pitch deviations and faults, and the inputs of the meshes made of them."""

from __future__ import annotations

import numpy as np

from fem.contact.law import MeshLaw
from fem.gears.deviations import sample_pitch_deviations
from fem.gears.faults import missing_tooth
from fem.gears.geometry import GearPair
from pipelines.layout import Layout
from pipelines.machine import MeshInput
from pipelines.scene import Scene


def clearances(scene: Scene, pair: GearPair, stage: int) -> dict[str, np.ndarray]:
    """Clearances (tooth,) by flank and gear of a stage (0-based): pitch deviations and missing teeth."""
    found: dict[str, np.ndarray] = {}
    for number, (name, gear) in enumerate((("pinion", pair.pinion), ("wheel", pair.wheel))):
        drive, coast = np.zeros(gear.teeth), np.zeros(gear.teeth)
        if scene.deviations.enabled:
            seed = 1000 * scene.deviations.seed + 2 * stage + number  # every gear its own sequence
            deviations = sample_pitch_deviations(gear, scene.deviations.iso_grade, seed)
            drive, coast = deviations.drive, deviations.coast
        for fault in scene.faults:
            if fault.stage == stage + 1 and fault.gear == name:
                drive, coast = missing_tooth(drive, fault.tooth), missing_tooth(coast, fault.tooth)
        found[f"drive_clearance_{name}"], found[f"coast_clearance_{name}"] = drive, coast
    return found


def mesh_inputs(scene: Scene, layout: Layout, laws: list[tuple[MeshLaw, MeshLaw]]) -> list[MeshInput]:
    """Laws with the clearances of every stage."""
    return [
        MeshInput(drive=drive, coast=coast, **clearances(scene, pair, stage))
        for stage, (pair, (drive, coast)) in enumerate(zip(layout.pairs, laws, strict=True))
    ]
