"""`gearcase detect`: how probably damage is found, at which rate of false alarms, and by which sensors."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from pipelines.cli.command_line import SCENE, argument, campaign_arguments, work_of
from pipelines.io.argument_types import count, from_zero

ARGUMENTS = (
    *SCENE,
    argument(
        "--over",
        metavar="KEY=VALUES",
        action="append",
        default=[],
        help="values of a key of the scene, as KEY=from:to:step or KEY=a,b,c; repeatable (default: the fault as in the "
        "scene)",
    ),
    argument("--seeds", metavar="N", type=count, default=10, help="damaged machines for each value (default 10)"),
    argument("--baseline", metavar="N", type=count, default=8, help="healthy machines to compare with (default 8)"),
    argument(
        "--healthy",
        metavar="N",
        type=count,
        default=20,
        help="further healthy machines, for the rate of false alarms (default 20)",
    ),
    argument(
        "--noise",
        metavar="RMS",
        type=from_zero,
        nargs="+",
        default=[],
        help="sensor noise, m/s2 rms; several values need no further simulations (default: that of the scene)",
    ),
    *campaign_arguments("detect"),
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Simulate healthy and damaged machines with different deviations. Print and write the probability of detection and
    the rate of false alarms over damage size, sensor noise and sensors. Takes minutes to hours: use --dry-run first.

    Example
    -------
    gearcase detect bench --over faults.1.depth_mm=0.5:3:0.5 --dry-run
    scenes      88
    labels      60 chipped-tooth, 28 healthy
    ...
    time        about 4 minutes on 2 cores: ...
    disk        about 324 MB in 440 files, 5 for each simulation
    """
    from pipelines.datasets.campaign import run_campaign
    from pipelines.datasets.campaign_scenes import sampled_scenes
    from pipelines.datasets.estimate import estimate
    from pipelines.datasets.workers import local_workers
    from pipelines.engine.progress import reported_count
    from pipelines.io.errors import InputError
    from pipelines.io.json_text import json_text
    from pipelines.io.user_files import write_whole
    from pipelines.machine.checks.checked_machine import checked_machine
    from pipelines.report.figures.frame_files import save_figure
    from pipelines.scene.presets import load_requested
    from pipelines.studies.detect.detectability_output import figure, plain, text
    from pipelines.studies.detect.detection_axis import parse_over
    from pipelines.studies.detect.detection_campaign import Design, detection_plan
    from pipelines.studies.detect.detection_study import study

    loaded = load_requested(options)
    machine = checked_machine(loaded.scene, loaded.source.shown)
    design = Design(
        over=tuple(map(parse_over, options.over)),
        baseline=options.baseline,
        healthy=options.healthy,
        damaged=options.seeds,
    )
    plan = detection_plan(loaded, machine, design)
    if options.dry_run:
        expected = estimate(plan, sampled_scenes(plan))
        if expected.refused:
            raise InputError(
                f"detect: {len(expected.refused)} scenes cannot be run. Message of the first: {expected.refused[0]}"
            )
        yield expected.text
        return
    folder = Path(options.out or f"campaigns/{plan.name}")
    finished = run_campaign(plan, folder, local_workers(options.processes), work_of(options), quiet=options.quiet)
    monitored = machine.monitored
    noises = tuple(dict.fromkeys(options.noise)) or (monitored.noise,)
    with local_workers(options.processes) as workers, reported_count("runs", quiet=options.quiet) as report:
        found = study(plan, folder, design, monitored.windows, noises, workers.executor, report)
    words = text(found)
    write_whole(folder / "detectability.txt", words)
    write_whole(folder / "detectability.json", json_text(plain(found)))
    save_figure(figure(found), folder / "detectability.png", dpi=130)
    yield words
    yield from finished.lines()
    yield f"figure: {folder / 'detectability.png'}"
