"""Teeth of a scene: what deviations and faults bring to the mesh laws, and the inputs of the meshes made of them."""

from __future__ import annotations

import numpy as np

from fem.contact.law import MeshLaw
from fem.contact.teeth import tooth_terms
from fem.gears.deviations import sample_pitch_deviations
from fem.gears.flank_deviations import sample_flank_deviations
from fem.gears.geometry import GearPair
from pipelines.plant.flanks import damage, damaged_teeth
from pipelines.plant.layout import Layout
from pipelines.plant.machine import MeshInput
from pipelines.scene.scene import Scene


def clearances(scene: Scene, pair: GearPair, stage: int) -> dict[str, np.ndarray]:
    """What the teeth of a stage (0-based) bring to its laws, by flank and gear: deviations, missing and damaged teeth.

    Clearances (tooth,) in m where that is all, else tooth terms (tooth, 6), see `fem.contact.teeth`.
    """
    found: dict[str, np.ndarray] = {}
    for number, (name, gear) in enumerate((("pinion", pair.pinion), ("wheel", pair.wheel))):
        seed = 1000 * scene.deviations.seed + 2 * stage + number  # every gear its own sequence
        include = scene.deviations.include if scene.deviations.enabled else ()
        flanks = {"drive": np.zeros(gear.teeth), "coast": np.zeros(gear.teeth)}
        if "pitch" in include:
            pitch = sample_pitch_deviations(gear, scene.deviations.iso_grade, seed)
            flanks = {"drive": pitch.drive, "coast": pitch.coast}
        faulty = fault_terms(scene, pair, stage, name)
        shapes = {}
        if "profile" in include or "helix" in include:
            wanted = {key: key in include for key in ("profile", "helix")}
            shapes = sample_flank_deviations(pair, name, scene.deviations.iso_grade, seed, **wanted)
        for flank, clearance in flanks.items():
            terms = clearance + (faulty if faulty.ndim == 1 else faulty[:, 0])
            if flank in shapes:
                shape = shapes[flank]
                terms = tooth_terms(gear.teeth, **(vars(shape) | {"clearance": terms + shape.clearance}))
            if faulty.ndim == 2:
                terms = terms if terms.ndim == 2 else tooth_terms(gear.teeth, clearance=terms)
                terms[:, -1] = faulty[:, -1]
            found[f"{flank}_clearance_{name}"] = terms
    return found


def fault_terms(scene: Scene, pair: GearPair, stage: int, gear: str) -> np.ndarray:
    """The faults of a gear of a stage (0-based) without deviations, on either flank.

    Clearances (tooth,), +inf at missing teeth, or tooth terms (tooth, 6) where teeth are damaged otherwise.
    """
    teeth = getattr(pair, gear).teeth
    clearance, variant = np.zeros(teeth), np.zeros(teeth)
    for fault in scene.faults:
        if fault.stage == stage + 1 and fault.gear == gear and fault.tooth is not None:
            clearance[fault.tooth] += damage(fault, +1).clearance
    damaged = damaged_teeth(scene, stage + 1, gear)
    if not damaged:
        return clearance
    variant[list(damaged)] = 1 + np.arange(len(damaged))
    return tooth_terms(teeth, clearance=clearance, variant=variant)


def mesh_inputs(scene: Scene, layout: Layout, laws: list[tuple[MeshLaw, MeshLaw]]) -> list[MeshInput]:
    """Laws with the teeth of every stage."""
    return [
        MeshInput(drive=drive, coast=coast, **clearances(scene, pair, stage))
        for stage, (pair, (drive, coast)) in enumerate(zip(layout.pairs, laws, strict=True))
    ]
