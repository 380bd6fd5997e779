"""`gearcase inspect`: pictures of a gear pair with its curve and of the casing with its key points."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.figures.views import LeftOut

if TYPE_CHECKING:
    from pipelines.engine.run_graph import Outcome
    from pipelines.engine.step import Graph
    from pipelines.figures.mesh_pictures import MeshView
    from pipelines.plant.plant import Plant


def main(options: argparse.Namespace) -> int:
    """Write gears_<n>.png and, for a meshed casing, casing.png; say what could not be rendered."""
    from pipelines.border.errors import InputError
    from pipelines.border.user_files import writable_folder
    from pipelines.engine.working import Work
    from pipelines.figures.callouts import casing_figure, gear_figure
    from pipelines.figures.film import save_figure
    from pipelines.figures.mesh_pictures import show_mesh, write_mesh
    from pipelines.figures.views import Picture
    from pipelines.runs.single_results import scene_graph
    from pipelines.scene.presets import load_asked
    from pipelines.steps import reporting
    from pipelines.steps.pair_curves import law_names, pair_laws

    folder = writable_folder(options.out)
    loaded, stage = load_asked(options), options.stage
    if stage > len(loaded.scene.stages):
        raise InputError(f"--stage {stage}: the scene has {len(loaded.scene.stages)} stages. Count from 1.")
    (graph, plant), work = scene_graph(loaded), Work(processes=options.processes, quiet=options.quiet)
    if options.stress or options.mesh is not None:
        from pipelines.runs.inspect_stress import stress_files

        stressed = stress_files(plant, graph, options, work)
        sys.stdout.write(_listed(stressed))
        return 0
    meshed = "casing mesh" in graph.steps
    elastic = "casing modes" in graph.steps
    wanted = [*law_names(plant), *(["casing"] if meshed else [])]
    if options.screen:
        wanted = [plant.law_names[stage - 1]]
    elif options.casing_mode:
        wanted = ["casing", *(["casing modes", "casing mesh"] if elastic else [])]
    outcome = work.build(graph, wanted)
    folder.mkdir(parents=True, exist_ok=True)
    if options.casing_mode:
        if not elastic:
            raise InputError(f"--casing-mode: a {plant.models['casing']} casing has no elastic modes")
        sys.stdout.write(_listed(_casing_mode_files(outcome, graph, plant.title, options.casing_mode, folder)))
        return 0
    if options.screen:
        show_mesh(mesh_view(plant, stage, outcome, options))
        return 0
    curves = reporting.stiffness_plots(pair_laws(plant, {name: outcome.value(name) for name in law_names(plant)}))
    gears = reporting.gear_picture(plant, stage)
    pictures: dict[str, Picture | LeftOut | None] = {f"gears_{stage}.png": gears}
    if meshed:
        pictures["casing.png"] = reporting.casing_picture(outcome.value("casing mesh"), outcome.value("casing"))
    for name, picture in pictures.items():
        if picture is None or isinstance(picture, LeftOut):
            sys.stdout.write(f"{name}: {picture.reason if picture else 'nothing to show'}\n")
            continue
        if name == "casing.png":
            figure = casing_figure(picture, f"Casing and key points of {plant.title}")
        else:
            title = gears_title(plant, stage)
            figure = gear_figure(picture, curves[stage - 1], reporting.gear_names(plant, stage), title)
        save_figure(figure, folder / name, dpi=115)
        sys.stdout.write(f"{folder / name}\n")
    mesh = write_mesh(mesh_view(plant, stage, outcome, options), folder / f"mesh_{stage}.png")
    sys.stdout.write(_listed(mesh))
    if not meshed:
        sys.stdout.write(f"casing {plant.models['casing']}: no mesh to show\n")
    return 0


def _listed(found: list[Path] | LeftOut) -> str:
    return f"{found.reason}\n" if isinstance(found, LeftOut) else "".join(f"{path}\n" for path in found)


def gears_title(plant: Plant, stage: int) -> str:
    """Title of the overview of a stage: scene, position, load and size."""
    from pipelines.figures.shapes import shown_cycle
    from pipelines.plant.flanks import first_tooth_fault

    pair, fault = plant.layout.pairs[stage - 1], first_tooth_fault(plant.faults, stage)
    cycle = shown_cycle(pair, None if fault is None else (fault.gear, fault.tooth or 0))
    meshes = "" if fault is None else f" (damaged tooth in mesh at {fault.tooth})"
    load = plant.facts.stages[stage - 1].shown_force
    size = f"centre distance {1000 * pair.axis_distance:.4g} mm, face width {1000 * pair.face_width:.4g} mm"
    return f"{plant.title}: stage {stage}\nmesh cycle {cycle}{meshes}, load {load:.4g} N; {size}"


def mesh_view(plant: Plant, stage: int, outcome: Outcome, options: argparse.Namespace) -> MeshView:
    """The mesh of a stage at its load, healthy and with its faults, around the passage of the first damaged tooth.

    Parameters
    ----------
    plant, outcome : the plant of a scene, and its results with the law of the stage
    stage : number of the stage, from 1
    options : of the command line: frames, position
    """
    import numpy as np

    from pipelines.figures.mesh_frames import mesh_frames, passage
    from pipelines.figures.mesh_pictures import MeshView
    from pipelines.figures.shapes import gear_view
    from pipelines.plant.assembly import mesh_faults
    from pipelines.plant.flanks import first_tooth_fault

    pair = plant.layout.pairs[stage - 1]
    law = outcome.value(f"law_{stage}")[0]
    load = plant.facts.stages[stage - 1].shown_force
    faults = plant.faults_of(stage)
    first = first_tooth_fault(plant.faults, stage)
    middle = float(first.tooth) if first is not None and first.tooth is not None else 0.0
    cycles = passage(middle, options.frames) if options.position is None else np.array([options.position])
    sound = np.zeros(pair.pinion.teeth), np.zeros(pair.wheel.teeth)
    states = [mesh_frames("healthy", pair, law, load, cycles, *sound)]
    if faults:
        teeth = mesh_faults(plant.machine.meshes[stage - 1])
        words = ", ".join(dict.fromkeys(fault.kind.replace("-", " ") for fault in faults))
        states.append(mesh_frames(words, pair, law, load, cycles, *teeth))
    marked = (first.gear, int(middle)) if first is not None else None
    gone = first is not None and first.kind == "missing-tooth"
    return MeshView(
        title=f"{plant.title}: stage {stage}, {pair.pinion.teeth}/{pair.wheel.teeth} teeth",
        gears=gear_view(pair),
        damaged=None if marked is None else gear_view(pair, marked, missing=gone, in_mesh=True),
        marked="" if first is None else f"{first.name.replace('-', ' ')} of the {first.gear}",
        model=law.model,
        force=load,
        cycles=cycles,
        states=tuple(states),
    )


def _casing_mode_files(outcome: Outcome, graph: Graph, title: str, number: int, folder: Path) -> list[Path] | LeftOut:
    """Still, film and page of a natural mode of the casing in its ground; InputError beyond the last one."""
    from fem.casing.reduced.modes import natural_modes
    from pipelines.border.errors import InputError
    from pipelines.figures.mode_pictures import ModeView, write_mode
    from pipelines.runs.casing_export import mode_shapes

    modes, mesh = outcome.value("casing modes")[0], outcome.value("casing mesh")
    factor = outcome.value("casing").stiffness_factor
    natural = natural_modes(modes, graph.steps["casing"].spec.mounts, stiffness_factor=factor)
    if number > len(natural.frequencies):
        raise InputError(f"--casing-mode {number}: the reduced casing has {len(natural.frequencies)} modes")
    view = ModeView(
        title=f"Casing of {title}",
        number=number,
        frequency=float(natural.frequencies[number - 1]),
        nodes=mesh.nodes,
        facets=mesh.facets,
        shape=mode_shapes(modes, natural, [number - 1])[0],
    )
    return write_mode(view, folder)
