"""`gearcase inspect --stress` and `--mesh`: the stress of loaded teeth as a picture and as a mesh."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.figures.views import LeftOut

if TYPE_CHECKING:
    from fem.contact.models.solid import Solid
    from pipelines.engine.step import Graph, Stage
    from pipelines.engine.working import Work
    from pipelines.plant.layout import Layout
    from pipelines.scene.scene import Scene


def stress_files(
    scene: Scene, layout: Layout, graph: Graph, options: argparse.Namespace, work: Work
) -> list[Path] | LeftOut:
    """stress_<n>.png with `--stress` and the mesh file of `--mesh`; the reason if the picture cannot be rendered.

    The mesh holds the damaged state where there is one.

    Raises
    ------
    InputError : unknown ending of the mesh file
    """
    from pipelines.engine.step import Graph
    from pipelines.figures.shapes import gear_view
    from pipelines.figures.stress_pictures import (
        StressView,
        checked_mesh_file,
        teeth_in_mesh,
        write_stress,
        write_teeth,
    )
    from pipelines.plant.facts import derive
    from pipelines.plant.flanks import fault_name, first_tooth_fault
    from pipelines.steps.pair_curves import load_shown

    stage = options.stage
    target = None if options.mesh is None else checked_mesh_file(options.mesh)
    pair, table, rung = layout.pairs[stage - 1], scene.stages[stage - 1], stress_rung(scene, stage)
    first = first_tooth_fault(scene, stage)
    cycle = float(first.tooth or 0) if first is not None else 0.0
    index = round((cycle if options.position is None else options.position) * rung.positions)
    force = load_shown(derive(scene, layout).stages[stage - 1], pair)
    added = stress_stages(scene, layout, stage, index, force)
    full = Graph([*graph.needed([f"law_{stage}"]), *added])
    wanted = [one.name for one in added[1:]]
    outcome = work.build(full, wanted)
    states = tuple(teeth_in_mesh(pair, outcome.value(name)) for name in wanted)
    folder, written = Path(options.out), []
    if target is not None:
        target.parent.mkdir(parents=True, exist_ok=True)
        write_teeth(states[-1], target)
        written.append(target)
    if not options.stress:
        return written
    folder.mkdir(parents=True, exist_ok=True)
    kinds = list(dict.fromkeys(fault.kind for fault in scene.faults if fault.stage == stage))
    gone = first is not None and first.kind == "missing-tooth"
    view = StressView(
        title=f"{scene.title}: stage {stage}, {table.pinion_teeth}/{table.wheel_teeth} teeth",
        gears=gear_view(pair),
        damaged=None if first is None else gear_view(pair, (first.gear, first.tooth or 0), missing=gone, in_mesh=True),
        marked="" if first is None else f"{fault_name(first).replace('-', ' ')} of the {first.gear}",
        note="the crack itself is not in the finite elements" if "cracked-tooth" in kinds else "",
        rung=f"rung solid, refinement {rung.refinement:g}, {rung.slices} slices along the face",
        force=force,
        cycle=index / rung.positions,
        names=("healthy", ", ".join(kind.replace("-", " ") for kind in kinds))[: len(states)],
        states=states,
    )
    picture = write_stress(view, folder / f"stress_{stage}.png")
    return picture if isinstance(picture, LeftOut) else [picture, *written]


def stress_rung(scene: Scene, stage: int) -> Solid:
    """The rung `solid` with the options of the stage, or with its defaults where the law has another rung."""
    from fem.contact.models.solid import Solid
    from pipelines.scene.tables.gears import SolidMesh

    mesh = scene.stages[stage - 1].mesh
    options = mesh if isinstance(mesh, SolidMesh) else SolidMesh()
    return Solid(slices=options.slices, refinement=options.refinement)


def stress_stages(scene: Scene, layout: Layout, stage: int, index: int, force: float) -> list[Stage]:
    """The compliance of a stage, and the stress of its teeth: healthy and, with faults, faulty."""
    import numpy as np

    from pipelines.engine.step import Stage
    from pipelines.plant.flanks import common_wear
    from pipelines.plant.teeth import fault_terms
    from pipelines.steps import modified_laws, stress

    pair, rung = replace(layout.pairs[stage - 1], backlash_allowance=0.0), stress_rung(scene, stage)
    sound = modified_laws.FlanksSpec(pair=pair, modifications=layout.modifications[stage - 1])
    worn = replace(
        sound,
        pinion_wear=common_wear(scene, stage, "pinion"),
        wheel_wear=common_wear(scene, stage, "wheel"),
    )
    found = [
        Stage(
            name=f"compliance_{stage}",
            kind="compliance",
            build=stress.build_compliance,
            spec=stress.ComplianceSpec(pair=pair, rung=rung),
            libraries=("numpy", "scipy"),
            seconds=6.0,
        )
    ]
    even = np.zeros(pair.pinion.teeth), np.zeros(pair.wheel.teeth)
    cases = [("sound", sound, even)]
    if any(fault.stage == stage for fault in scene.faults):
        faulty = (fault_terms(scene, pair, stage - 1, "pinion"), fault_terms(scene, pair, stage - 1, "wheel"))
        cases.append(("faulty", worn, faulty))
    for name, spec, (pinion, wheel) in cases:
        found.append(
            Stage(
                name=f"{name}_stress_{stage}",
                kind="stress",
                build=stress.build,
                spec=stress.StressSpec(
                    flanks=spec, rung=rung, index=index, force=force, pinion_terms=pinion, wheel_terms=wheel
                ),
                takes=(f"compliance_{stage}", f"law_{stage}"),
                libraries=("numpy", "scipy"),
                seconds=6.0,
            )
        )
    return found
