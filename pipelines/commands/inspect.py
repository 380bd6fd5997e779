"""`gearcase inspect`: pictures of a gear pair with its curve and of the casing with its key points."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def main(options: argparse.Namespace) -> int:
    """Write gears_<n>.png and, for a meshed casing, casing.png; say what could not be rendered."""
    from pipelines.build import run_graph
    from pipelines.building import reporting
    from pipelines.cache import Cache
    from pipelines.callouts import casing_figure, gear_figure
    from pipelines.derived import derive
    from pipelines.errors import InputError
    from pipelines.layout import lay_out
    from pipelines.pictures import LeftOut, Picture
    from pipelines.study import plan_study
    from pipelines.terminal import shown_progress
    from pipelines.trade.presets import load_asked

    loaded = load_asked(options)
    scene, stage = loaded.scene, options.stage
    if stage > len(scene.stages):
        raise InputError(f"--stage {stage}: the scene has {len(scene.stages)} stages. Count from 1.")
    graph = plan_study(loaded, with_control=False, both_loads=False).graph
    laws = [f"law_{number}" for number in range(1, len(scene.stages) + 1)]
    meshed = "casing mesh" in graph.stages
    wanted = [*laws, *(["casing"] if meshed else [])]
    with shown_progress(len(graph.needed(wanted).stages), quiet=options.quiet) as observer:
        outcome = run_graph(graph, Cache(), wanted, observer=observer, processes=options.processes)
    layout = lay_out(scene)
    curves = reporting.stiffness_plots(scene, layout, derive(scene, layout), [outcome.value(name) for name in laws])
    folder = Path(options.out)
    folder.mkdir(parents=True, exist_ok=True)
    gears = reporting.gear_picture(scene, layout, stage)
    pictures: dict[str, Picture | LeftOut | None] = {f"gears_{stage}.png": gears}
    if meshed:
        pictures["casing.png"] = reporting.casing_picture(outcome.value("casing mesh"), outcome.value("casing"))
    for name, picture in pictures.items():
        if picture is None or isinstance(picture, LeftOut):
            sys.stdout.write(f"{name}: {picture.reason if picture else 'nothing to show'}\n")
            continue
        if name == "casing.png":
            figure = casing_figure(picture)
        else:
            figure = gear_figure(picture, curves[stage - 1], reporting.gear_names(scene, stage))
        figure.savefig(folder / name, dpi=115)
        sys.stdout.write(f"{folder / name}\n")
    if not meshed:
        sys.stdout.write(f"casing {scene.casing.model}: no mesh to show\n")
    return 0
