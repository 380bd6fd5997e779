"""`gearcase inspect`: pictures of a gear pair with its curve and of the casing with its key points."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.figures.views import LeftOut

if TYPE_CHECKING:
    from pipelines.engine.run_graph import Outcome
    from pipelines.figures.mesh_pictures import MeshView
    from pipelines.plant.layout import Layout
    from pipelines.scene.scene import Scene


def main(options: argparse.Namespace) -> int:
    """Write gears_<n>.png and, for a meshed casing, casing.png; say what could not be rendered."""
    from pipelines.border.errors import InputError
    from pipelines.border.user_files import writable_folder
    from pipelines.engine.working import Work
    from pipelines.figures.callouts import casing_figure, gear_figure
    from pipelines.figures.film import save_figure
    from pipelines.figures.mesh_pictures import show_mesh, write_mesh
    from pipelines.figures.views import Picture
    from pipelines.plant.layout import lay_out
    from pipelines.runs.built import law_names, scene_graph
    from pipelines.scene.presets import load_asked
    from pipelines.steps import reporting
    from pipelines.steps.pair_curves import pair_laws

    folder = writable_folder(options.out)
    loaded = load_asked(options)
    scene, stage = loaded.scene, options.stage
    if stage > len(scene.stages):
        raise InputError(f"--stage {stage}: the scene has {len(scene.stages)} stages. Count from 1.")
    graph, work = scene_graph(loaded), Work(processes=options.processes, quiet=options.quiet)
    if options.stress or options.mesh is not None:
        from pipelines.runs.inspect_stress import stress_files

        stressed = stress_files(scene, lay_out(scene), graph, options, work)
        sys.stdout.write(_listed(stressed))
        return 0
    laws = law_names(scene)
    meshed = "casing mesh" in graph.stages
    elastic = "casing modes" in graph.stages
    wanted = [*laws, *(["casing"] if meshed else [])]
    if options.screen:
        wanted = [f"law_{stage}"]
    elif options.casing_mode:
        wanted = ["casing", *(["casing modes", "casing mesh"] if elastic else [])]
    outcome = work.build(graph, wanted)
    folder.mkdir(parents=True, exist_ok=True)
    if options.casing_mode:
        if not elastic:
            raise InputError(f"--casing-mode: a {scene.casing.model} casing has no elastic modes")
        sys.stdout.write(_listed(casing_mode_files(outcome, scene, options.casing_mode, folder)))
        return 0
    layout = lay_out(scene)
    if options.screen:
        show_mesh(mesh_view(scene, layout, stage, outcome, options))
        return 0
    curves = reporting.stiffness_plots(pair_laws(scene, layout, [outcome.value(name) for name in laws]))
    gears = reporting.gear_picture(scene, layout, stage)
    pictures: dict[str, Picture | LeftOut | None] = {f"gears_{stage}.png": gears}
    if meshed:
        pictures["casing.png"] = reporting.casing_picture(outcome.value("casing mesh"), outcome.value("casing"))
    for name, picture in pictures.items():
        if picture is None or isinstance(picture, LeftOut):
            sys.stdout.write(f"{name}: {picture.reason if picture else 'nothing to show'}\n")
            continue
        if name == "casing.png":
            figure = casing_figure(picture, f"Casing and key points of {scene.title}")
        else:
            title = gears_title(scene, layout, stage)
            figure = gear_figure(picture, curves[stage - 1], reporting.gear_names(scene, stage), title)
        save_figure(figure, folder / name, dpi=115)
        sys.stdout.write(f"{folder / name}\n")
    mesh = write_mesh(mesh_view(loaded.scene, layout, stage, outcome, options), folder / f"mesh_{stage}.png")
    sys.stdout.write(_listed(mesh))
    if not meshed:
        sys.stdout.write(f"casing {scene.casing.model}: no mesh to show\n")
    return 0


def _listed(found: list[Path] | LeftOut) -> str:
    return f"{found.reason}\n" if isinstance(found, LeftOut) else "".join(f"{path}\n" for path in found)


def gears_title(scene: Scene, layout: Layout, stage: int) -> str:
    """Title of the overview of a stage: scene, position, load and size."""
    from pipelines.figures.shapes import shown_cycle
    from pipelines.plant.facts import derive
    from pipelines.plant.flanks import first_tooth_fault
    from pipelines.steps.pair_curves import load_shown

    pair, fault = layout.pairs[stage - 1], first_tooth_fault(scene, stage)
    cycle = shown_cycle(pair, None if fault is None else (fault.gear, fault.tooth or 0))
    meshes = "" if fault is None else f" (damaged tooth in mesh at {fault.tooth})"
    load = load_shown(derive(scene, layout).stages[stage - 1], pair)
    size = f"centre distance {1000 * pair.axis_distance:.4g} mm, face width {1000 * pair.face_width:.4g} mm"
    return f"{scene.title}: stage {stage}\nmesh cycle {cycle}{meshes}, load {load:.4g} N; {size}"


def mesh_view(scene: Scene, layout: Layout, stage: int, outcome: Outcome, options: argparse.Namespace) -> MeshView:
    """The mesh of a stage at its load, healthy and with its faults, around the passage of the first damaged tooth."""
    import numpy as np

    from pipelines.figures.mesh_frames import mesh_frames, passage
    from pipelines.figures.mesh_pictures import MeshView
    from pipelines.figures.shapes import gear_view
    from pipelines.plant.facts import derive
    from pipelines.plant.flanks import fault_name, first_tooth_fault
    from pipelines.plant.teeth import fault_terms
    from pipelines.steps.pair_curves import load_shown

    pair, table = layout.pairs[stage - 1], scene.stages[stage - 1]
    law = outcome.value(f"law_{stage}")[0]
    load = load_shown(derive(scene, layout).stages[stage - 1], pair)
    faults = [fault for fault in scene.faults if fault.stage == stage]
    first = first_tooth_fault(scene, stage)
    middle = float(first.tooth) if first is not None and first.tooth is not None else 0.0
    cycles = passage(middle, options.frames) if options.position is None else np.array([options.position])
    sound = np.zeros(pair.pinion.teeth), np.zeros(pair.wheel.teeth)
    states = [mesh_frames("healthy", pair, law, load, cycles, *sound)]
    if faults:
        teeth = [fault_terms(scene, pair, stage - 1, gear) for gear in ("pinion", "wheel")]
        words = ", ".join(dict.fromkeys(fault.kind.replace("-", " ") for fault in faults))
        states.append(mesh_frames(words, pair, law, load, cycles, *teeth))
    marked = (first.gear, int(middle)) if first is not None else None
    gone = first is not None and first.kind == "missing-tooth"
    return MeshView(
        title=f"{scene.title}: stage {stage}, {table.pinion_teeth}/{table.wheel_teeth} teeth",
        gears=gear_view(pair),
        damaged=None if marked is None else gear_view(pair, marked, missing=gone, in_mesh=True),
        marked="" if first is None else f"{fault_name(first).replace('-', ' ')} of the {first.gear}",
        model=law.model,
        force=load,
        cycles=cycles,
        states=tuple(states),
    )


def casing_mode_files(outcome: Outcome, scene: Scene, number: int, folder: Path) -> list[Path] | LeftOut:
    """Still, film and page of a natural mode of the casing in its ground; InputError beyond the last one."""
    from fem.casing.reduced.modes import natural_modes
    from pipelines.border.errors import InputError
    from pipelines.figures.mode_pictures import ModeView, write_mode
    from pipelines.runs.casing_export import mode_shapes
    from pipelines.steps.graph import casing_mounts

    modes, mesh = outcome.value("casing modes")[0], outcome.value("casing mesh")
    factor = outcome.value("casing").stiffness_factor
    natural = natural_modes(modes, casing_mounts(scene), stiffness_factor=factor)
    if number > len(natural.frequencies):
        raise InputError(f"--casing-mode {number}: the reduced casing has {len(natural.frequencies)} modes")
    view = ModeView(
        title=f"Casing of {scene.title}",
        number=number,
        frequency=float(natural.frequencies[number - 1]),
        nodes=mesh.nodes,
        facets=mesh.facets,
        shape=mode_shapes(modes, natural, [number - 1])[0],
    )
    return write_mode(view, folder)
