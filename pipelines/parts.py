"""What each stage of a run computes: plain functions from specs (frozen, in SI) to records.

A spec holds all that its function reads from the scene, so equal specs may share one result.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.contact.law import MeshLaw
from fem.gears.deviations import sample_pitch_deviations
from fem.gears.faults import missing_tooth
from fem.gears.geometry import GearPair
from pipelines.layout import Layout
from pipelines.machine import MeshInput
from pipelines.scene import IsoMesh, MeshModel, Scene


@dataclass(frozen=True, kw_only=True)
class LawSpec:
    """A gear pair and the rung of its mesh law; `line_load` (N/m) is read by the rung `iso` alone, else 0."""

    pair: GearPair
    mesh: MeshModel
    line_load: float


def law_spec(mesh: MeshModel, pair: GearPair, line_load: float) -> LawSpec:
    """The spec of a law; the play between the flanks is left out, no law depends on it."""
    from dataclasses import replace

    return LawSpec(
        pair=replace(pair, backlash_allowance=0.0),
        mesh=mesh,
        line_load=line_load if isinstance(mesh, IsoMesh) else 0.0,
    )


def mesh_laws(spec: LawSpec) -> tuple[MeshLaw, MeshLaw]:
    """The laws of drive and coast flank."""
    if isinstance(spec.mesh, IsoMesh):
        from fem.contact.iso import Iso

        rung = Iso(n_slices=spec.mesh.slices, line_load=spec.line_load or None)
        return rung.law(spec.pair, "drive"), rung.law(spec.pair, "coast")
    from fem.contact.plane import Plane

    return Plane(n_slices=spec.mesh.slices, refinement=spec.mesh.refinement).laws(spec.pair)


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
