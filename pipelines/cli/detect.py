"""`gearcase detect`: how probably damage is found, at which rate of false alarms, and by which sensors."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def main(options: argparse.Namespace) -> int:
    """Simulate what is missing; print the probabilities and write them with their figure."""
    from pipelines.datasets.campaign import planned, run_campaign
    from pipelines.datasets.estimate import estimate
    from pipelines.datasets.shown_progress import lines_now_and_then, shown_campaign
    from pipelines.datasets.workers import local_workers
    from pipelines.engine.working import Work
    from pipelines.io.errors import InputError
    from pipelines.io.user_files import write_whole
    from pipelines.machine.checks.validity import checked_plant
    from pipelines.report.figures.film import save_figure
    from pipelines.runs.run_folder import write_json
    from pipelines.scene.presets import load_asked
    from pipelines.studies.detect.design import Design, detection_plan
    from pipelines.studies.detect.over import parse_over
    from pipelines.studies.detect.page import figure, plain, text
    from pipelines.studies.detect.study import study

    loaded = load_asked(options)
    plant = checked_plant(loaded.scene, loaded.source.shown)
    design = Design(
        over=tuple(map(parse_over, options.over)),
        baseline=options.baseline,
        healthy=options.healthy,
        damaged=options.seeds,
    )
    plan = detection_plan(loaded, plant, design)
    if options.dry_run:
        expected = estimate(plan, planned(plan))
        if expected.refused:
            raise InputError(f"detect: {expected.refused} scenes cannot be run; the first: {expected.first_refusal}")
        sys.stdout.write(expected.to_text())
        return 0
    folder = Path(options.out or f"campaigns/{plan.name}")
    work = Work(processes=options.processes, quiet=options.quiet)
    with shown_campaign(quiet=options.quiet) as shown:
        finished = run_campaign(
            plan, folder, local_workers(options.processes), work, begun=shown.begun, told=shown.told
        )
    looked_for = plant.looked_for
    noises = tuple(dict.fromkeys(options.noise)) or (looked_for.noise,)
    with local_workers(options.processes) as workers:
        found = study(
            plan, folder, design, looked_for.windows, noises, workers.executor, lines_now_and_then(quiet=options.quiet)
        )
    words = text(found)
    write_whole(folder / "detectability.txt", words)
    write_json(folder / "detectability.json", plain(found))
    save_figure(figure(found), folder / "detectability.png", dpi=130)
    sys.stdout.write(words)
    sys.stdout.write("".join(f"{line}\n" for line in finished.lines()))
    sys.stdout.write(f"figure: {folder / 'detectability.png'}\n")
    return 0
