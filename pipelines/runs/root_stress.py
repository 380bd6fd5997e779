"""Root stresses of loaded teeth by finite elements, for `gearcase inspect --stress`, and the mesh file of `--mesh`."""

from __future__ import annotations

import argparse
import math
import warnings
from dataclasses import replace
from typing import Any

from fem.contact.models.mesh_model import LawSpec
from fem.contact.models.solid import Solid
from fem.gears.geometry import GearPair
from pipelines.engine.run_graph import Work
from pipelines.engine.step import Graph, Step
from pipelines.io.errors import SceneWarning
from pipelines.io.user_files import writable_file
from pipelines.machine.machine_model import MachineModel
from pipelines.report.figures.tooth_stress_pictures import StressView
from pipelines.report.figures.views import Teeth

CRACK = "cracked-tooth"
_NOTE = "the crack is not in the finite elements: the stress is that of an uncracked tooth"
_REMEDY = (
    "For the stress at the crack, write the mesh with --mesh FILE.inp, .msh or .bdf, and model the crack and the load "
    "in another finite-element program."
)


def loaded_teeth(
    machine: MachineModel, graph: Graph, options: argparse.Namespace, work: Work
) -> tuple[list[dict[str, Any]], StressView]:
    """Compute the stress of loaded teeth and write the mesh file of `--mesh`; root stresses, and what a picture shows.

    The mesh is that with the faults if any fault is in the finite elements.

    Parameters
    ----------
    machine, graph : the machine of a scene in SI, and its steps
    options : of the command line: stage, torque, position, mesh
    work : executor of the steps

    Raises
    ------
    InputError : the suffix of the mesh file is not known

    Warns
    -----
    SceneWarning : the stage has a crack, which the finite elements do not contain
    """
    from pipelines.engine.step import Graph
    from pipelines.report.figures.tooth_stress_pictures import (
        FORMATS,
        StressView,
        teeth_in_mesh,
        write_teeth,
    )
    from pipelines.runs.inspect_gears import InspectedStage
    from pipelines.steps.pair_curves import acting, law_names, pair_laws

    stage = options.stage
    target = None if options.mesh is None else writable_file(options.mesh, "--mesh", FORMATS)
    pair, model = machine.layout.pairs[stage - 1], stress_model(machine.laws[stage - 1])
    outcome = work.build(graph, law_names(machine))
    found = pair_laws(machine, outcome.value)[stage - 1]
    index = round((acting(found) if options.position is None else options.position) * model.positions)
    force = machine.facts.stages[stage - 1].shown_force
    if options.torque is not None:
        force = options.torque / pair.pinion.base_radius
    added = _stress_steps(machine, stage, index, force)
    full = Graph([*graph.needed([f"law_{stage}"]), *added])
    stresses = [one.name for one in added[1:]]
    outcome = work.build(full, stresses)
    states = tuple(teeth_in_mesh(pair, outcome.value(name)) for name in stresses)
    kinds = list(dict.fromkeys(fault.kind for fault in machine.faults_of(stage)))
    crack = _NOTE if CRACK in kinds else ""
    if crack:
        warnings.warn(f"stage {stage}: {crack}. {_REMEDY}", SceneWarning, stacklevel=2)
    shown = InspectedStage(machine=machine, laws=found).shown()
    if target is not None:
        target.parent.mkdir(parents=True, exist_ok=True)
        write_teeth(states[-1], target, shown["gears"].frame)
    healthy_name = "healthy, without the crack" if crack else "healthy"
    names = (healthy_name, ", ".join(kind.replace("-", " ") for kind in kinds))[: len(states)]
    roots = [root_stresses(pair, teeth) for teeth in states]
    view = StressView(
        **shown,
        note=crack,
        model=f"model solid, refinement {model.refinement:g}, {model.slices} slices along the face",
        force=force,
        cycle=index / model.positions,
        names=names,
        states=states,
        roots=tuple(
            max(((row["root stress MPa"], row.pop("place")) for row in own), key=lambda one: one[0]) for own in roots
        ),
    )
    rows = [
        {"teeth": name, **row, "y mm": found.sense * row["y mm"]}
        for name, own in zip(names, roots, strict=True)
        for row in own
    ]
    return rows, view


def root_stresses(pair: GearPair, teeth: Teeth) -> list[dict[str, Any]]:
    """The largest von Mises stress (MPa) on the fillets of the loaded sides of each gear, and its place.

    Places within 0.3 modules of a contact line are left out, because the smoothed contact stress reaches them. A row
    has the number of the tooth pair, the diameter (mm), the face coordinate of the law from mid face (mm) and the
    place (3,) of the points of the teeth (m).
    """
    import numpy as np

    from fem.contact.models.solid_stress import SMOOTHED

    lines, rows = teeth.line_points[np.isfinite(teeth.line_load)], []
    places = teeth.points[teeth.root]
    away = np.linalg.norm(places[:, None] - lines, axis=2).min(axis=1) > SMOOTHED * pair.pinion.normal_module
    for number, gear in enumerate(("pinion", "wheel"), 1):
        stress = np.where(away & (teeth.root_gear == number), teeth.von_mises[teeth.root], -1.0)
        at = int(stress.argmax())
        x, y, z = places[at] - [(number - 1) * pair.axis_distance, 0.0, 0.0]
        rows.append(
            {
                "gear": gear,
                "tooth pair": int(teeth.root_pair[at]),
                "root stress MPa": float(stress[at]) / 1e6,
                "diameter mm": 2000.0 * math.hypot(x, y),
                "y mm": 1000.0 * float(z),
                "place": places[at],
            }
        )
    return rows


def stress_model(law: LawSpec) -> Solid:
    """The model `solid` with the options of a law, or with its defaults if the law has another model."""
    mesh = law.mesh
    return Solid(slices=mesh.slices, refinement=mesh.refinement) if isinstance(mesh, Solid) else Solid()


def root_step(machine: MachineModel, stage: int) -> Step:
    """The step of the root stresses of a stage (from 1) by unit forces on the flanks."""
    from fem.contact.models.solid_stress import root_stress
    from pipelines.engine.step import Step

    return Step(
        name=f"root stress of stage {stage}",
        kind="root-stress",
        build=root_stress,
        spec={"pair": machine.flanks[stage - 1].pair, "model": stress_model(machine.laws[stage - 1])},
        libraries=("numpy", "scipy"),
        seconds=9.0,
    )


def _stress_steps(machine: MachineModel, stage: int, index: int, force: float) -> list[Step]:
    """Steps of the compliance of a stage and of the stress of its teeth, healthy and, with faults, faulty."""
    import numpy as np

    from pipelines.engine.step import Step
    from pipelines.machine.tooth_terms import mesh_faults
    from pipelines.steps import stress

    modified, model = machine.flanks[stage - 1], stress_model(machine.laws[stage - 1])
    worn = replace(modified, pinion_damage=(), wheel_damage=())
    pair = modified.pair
    found = [
        Step(
            name=f"compliance of stage {stage}",
            kind="compliance",
            build=stress.build_compliance,
            spec={"pair": pair, "model": model},
            libraries=("numpy", "scipy"),
            seconds=6.0,
        )
    ]
    even = np.zeros(pair.pinion.teeth), np.zeros(pair.wheel.teeth)
    cases = [("healthy", modified.healthy, even)]
    if any(fault.kind != CRACK for fault in machine.faults_of(stage)):  # a crack is not in these finite elements
        cases.append(("faulty", worn, mesh_faults(machine.parts.meshes[stage - 1])))
    for name, spec, (pinion, wheel) in cases:
        found.append(
            Step(
                name=f"stress of {name} teeth of stage {stage}",
                kind="stress",
                build=stress.build,
                spec={
                    "flanks": spec,
                    "model": model,
                    "index": index,
                    "force": force,
                    "pinion_terms": pinion,
                    "wheel_terms": wheel,
                },
                takes={"record": f"compliance of stage {stage}", "laws": f"law_{stage}"},
                libraries=("numpy", "scipy"),
                seconds=6.0,
            )
        )
    return found
