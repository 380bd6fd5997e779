"""`gearcase inspect`: pictures of a gear pair with its curve and of the casing with its key points."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.cli.command_line import JSON, WORK, argument, scene_and_work
from pipelines.io.argument_types import count, mode_number, number, path, positive

if TYPE_CHECKING:
    import numpy as np

    from pipelines.engine.run_graph import Outcome, Work
    from pipelines.engine.step import Graph
    from pipelines.machine.machine_model import MachineModel
    from pipelines.runs.inspect_gears import InspectedStage

ARGUMENTS = (
    *WORK,
    argument(
        "--out", metavar="FOLDER", type=path, default=".", help="folder for the pictures (default: the working folder)"
    ),
    argument("--stage", type=count, metavar="N", default=1, help="gear stage to show (default 1)"),
    argument(
        "--torque",
        metavar="N_M",
        type=positive,
        help="torque on the pinion of this stage, N m (default: that of the scene)",
    ),
    argument(
        "--position",
        type=number,
        metavar="C",
        help="show only this position, in mesh cycles; at position N the damaged tooth N makes contact at the pitch "
        "point (default: an animation over one mesh cycle)",
    ),
    argument("--frames", type=count, metavar="N", default=17, help="number of pictures in the animation (default 17)"),
    argument(
        "--stress",
        action="store_true",
        help="show the von Mises stress of the loaded teeth instead, by the model `solid` (PNG), and print the largest "
        "root stress of each gear at this position of the mesh cycle (--position)",
    ),
    argument(
        "--mesh",
        metavar="FILE",
        type=path,
        help="write the hexahedral mesh of the loaded teeth instead, .vtu, .inp, .msh or .bdf",
    ),
    argument("--screen", action="store_true", help="open a window with a slider for the position instead"),
    argument(
        "--casing-mode",
        type=mode_number,
        metavar="N",
        help="show natural mode N of the casing instead (PNG, GIF and HTML); all: sheets of 24 modes up "
        "to casing.band_Hz (PNG)",
    ),
    JSON,
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Write pictures of a gear pair in mesh with its stiffness curve and contact pattern, and of the casing mesh.
    --stress, --mesh and --casing-mode write other pictures or files instead. Takes seconds, and up to minutes with
    the mesh model `solid`.

    Example
    -------
    gearcase inspect minimal --position 0
    gears_1.png
    mesh_1.png
    pattern_1.png
    casing rigid: no mesh to show
    """
    from pipelines.io.errors import InputError
    from pipelines.io.user_files import writable_folder
    from pipelines.machine.checks.strength import refuse_overload
    from pipelines.report.figures.render import show_mesh
    from pipelines.runs.inspect_gears import InspectedStage
    from pipelines.runs.single_results import scene_graph
    from pipelines.steps.pair_curves import law_names, pair_laws

    folder = writable_folder(options.out)
    (loaded, work), stage = scene_and_work(options), options.stage
    if stage > len(loaded.scene.stages):
        last = len(loaded.scene.stages)
        numbers = f"a number from 1 to {last}" if last > 1 else "1, the only stage of the scene"
        raise InputError(f"--stage {stage}: there is no such stage. Set {numbers}.")
    graph, machine = scene_graph(loaded)
    if options.json and not options.stress:
        raise InputError("--json prints root stresses. Add --stress, or delete --json.")
    if options.torque is not None:
        refuse_overload(stage, machine.layout.pairs[stage - 1], options.torque)
    if options.stress or options.mesh is not None:
        yield from _stress(machine, graph, options, work)
        return
    folder.mkdir(parents=True, exist_ok=True)
    if options.casing_mode:
        yield from _casing_mode(graph, machine, options.casing_mode, str(folder / f"casing-{loaded.name}"), work)
        return
    outcome = work.build(graph, law_names(machine))
    pairs = pair_laws(machine, outcome.value)
    laws = pairs[stage - 1]
    if options.torque is not None:
        laws = dataclasses.replace(laws, force=options.torque / laws.pair.pinion.base_radius)
    shown = InspectedStage(machine=machine, laws=laws)
    frames = options.frames if options.position is None else 1
    if options.screen:
        show_mesh(shown.mesh_view(_cycles(shown, options)))
        return
    yield from _listed(shown.write_overview, folder / f"gears_{stage}.png")
    yield from _write_mesh(shown, folder / f"mesh_{stage}", options, frames)
    yield from _listed(shown.write_pattern, folder / f"pattern_{stage}.png")
    yield from _write_casing(graph, machine, folder, work)


def _stress(machine: MachineModel, graph: Graph, options: argparse.Namespace, work: Work) -> Iterator[str]:
    """Root stresses, and the files of --stress and --mesh."""
    from pipelines.io.json_text import json_text
    from pipelines.io.text_table import grid
    from pipelines.report.figures.tooth_stress_pictures import write_stress
    from pipelines.runs.root_stress import loaded_teeth

    rows, view = loaded_teeth(machine, graph, options, work)
    files = [] if options.mesh is None else [str(options.mesh)]
    if options.stress:
        folder = Path(options.out)
        folder.mkdir(parents=True, exist_ok=True)
        files = [*_listed(write_stress, view, folder / f"stress_{options.stage}.png"), *files]
    if options.json:
        yield json_text({"root_stress": rows, "cycle": view.cycle, "force_N": view.force, "files": files})
        return
    title = (
        f"Largest von Mises stress of the tooth roots on the loaded side, mesh cycle {view.cycle:.4g}, load "
        f"{view.force:.4g} N. Pair n makes contact at the pitch point at cycle n; y is from mid face"
    )
    if options.stress:
        yield grid(title, rows).to_text()
    yield from files


def _cycles(shown: InspectedStage, options: argparse.Namespace) -> np.ndarray:
    import numpy as np

    from pipelines.report.figures.tooth_mesh_frames import passage

    return passage(shown.laws.cycle, options.frames) if options.position is None else np.array([options.position])


def _write_mesh(shown: InspectedStage, stem: Path, options: argparse.Namespace, frames: int) -> Iterator[str]:
    """Write a picture where the damage acts, or at the given position; with more than one frame also the animation."""
    import numpy as np

    from pipelines.engine.progress import reported_count
    from pipelines.report.figures.tooth_mesh_pictures import write_film, write_still
    from pipelines.steps.pair_curves import acting

    cycle = acting(shown.laws) if options.position is None else options.position
    yield from _listed(write_still, shown.mesh_view(np.array([cycle])), stem)
    if frames == 1:
        return

    with reported_count("pictures", quiet=options.quiet) as report:
        written = _listed(write_film, shown.mesh_view(_cycles(shown, options)), stem, report)
    yield from written


def _write_casing(graph: Graph, machine: MachineModel, folder: Path, work: Work) -> Iterator[str]:
    from pipelines.report.figures.frame_files import save_figure
    from pipelines.report.figures.labelled_pictures import casing_figure
    from pipelines.report.figures.views import NotRendered
    from pipelines.steps.pictures import rendered_casing

    if "casing mesh" not in graph.steps:
        yield f"casing {machine.models['casing']}: no mesh to show"
        return
    mesh = work.build(graph, ["casing mesh"]).value("casing mesh")
    try:
        picture = rendered_casing(mesh, machine.sensors)
    except NotRendered as left_out:
        yield f"casing.png: {left_out}"
        return
    save_figure(casing_figure(picture, f"Casing and key points of {machine.title}"), folder / "casing.png", dpi=115)
    yield str(folder / "casing.png")


def _casing_mode(graph: Graph, machine: MachineModel, number: int | str, stem: str, work: Work) -> Iterator[str]:
    from pipelines.engine.progress import reported_count
    from pipelines.io.errors import InputError

    if "casing mesh" not in graph.steps or "casing modes" not in graph.steps:
        raise InputError(
            "--casing-mode: the casing has no finite-element mesh with elastic modes to draw; imported matrices have "
            "none. Set casing.model to craig-bampton, and casing.housing to a shape, a CAD file or a mesh."
        )
    outcome = work.build(graph, ["casing", "casing modes"])
    with reported_count("pictures", quiet=work.quiet) as report:
        written = _listed(_casing_mode_files, outcome, graph, machine.title, number, stem, report)
    yield from written


def _listed(write: Callable[..., Path | list[Path]], *given: object) -> list[str]:
    """The names of the files that a function writes, or the reason why it writes none."""
    from pipelines.report.figures.views import NotRendered

    try:
        written = write(*given)
    except NotRendered as left_out:
        return [str(left_out)]
    return [str(path) for path in (written if isinstance(written, list) else [written])]


def _casing_mode_files(
    outcome: Outcome,
    graph: Graph,
    title: str,
    number: int | str,
    stem: str,
    report: Callable[[int, int], None],
) -> list[Path]:
    """Write picture, animation and page of a natural mode of the mounted casing, or a sheet of all modes in the band.

    Raises
    ------
    InputError : a number beyond the last mode
    """
    from fem.casing.reduced.casing_modes import natural_modes
    from fem.casing.reduced.reduced_body import MODES_OVER_BAND
    from pipelines.io.errors import InputError
    from pipelines.report.figures.mode_pictures import ModeView, write_mode, write_modes
    from pipelines.runs.single_results import mode_shapes

    modes = outcome.value("casing modes")[0]
    factor = outcome.value("casing").stiffness_factor
    natural = natural_modes(modes, graph.steps["casing"].spec.mounts, stiffness_factor=factor)
    if isinstance(number, int) and number > len(natural.frequencies):
        raise InputError(
            f"--casing-mode {number}: the reduced casing has {len(natural.frequencies)} modes. Give a lower number, "
            "or all."
        )

    def view(place: int, shape: np.ndarray) -> ModeView:
        return ModeView(
            title=f"Casing of {title}",
            number=place + 1,
            frequency=float(natural.frequencies[place]),
            nodes=modes.nodes,
            facets=modes.facets,
            shape=shape,
        )

    if isinstance(number, int):
        return write_mode(view(number - 1, mode_shapes(modes, natural, [number - 1])[0]), stem)
    limit = graph.steps["casing"].spec.limit
    inside = len(natural.frequencies) if limit is None else int((natural.frequencies <= limit / MODES_OVER_BAND).sum())
    places = range(max(inside, 1))
    views = (view(place, mode_shapes(modes, natural, [place])[0]) for place in places)
    return write_modes(views, len(places), stem, report)
