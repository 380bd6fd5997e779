"""`gearcase campaign`: simulate every scene of a plan into one labelled data set."""

from __future__ import annotations

import argparse

from pipelines.cli.command_line import DRY_RUN, QUIET, SCENES_AT_ONCE, Printed, argument, work_of
from pipelines.io.argument_types import path

ARGUMENTS = (
    argument("plan", metavar="PLAN", type=path, help="plan of the campaign, a file that ends in .toml"),
    argument("--out", metavar="FOLDER", type=path, help="folder of the data set (default: ./campaigns/<plan>)"),
    DRY_RUN,
    SCENES_AT_ONCE,
    argument("--scheduler", metavar="ADDRESS", help="address of a running Dask scheduler, or its scheduler file"),
    argument("--cluster", action="store_true", help="start a local Dask scheduler with a dashboard"),
    argument("--retry-failed", action="store_true", help="simulate failed runs again"),
    QUIET,
)


def main(options: argparse.Namespace) -> Printed:
    """Simulate all scenes of a plan and write them as one labelled data set. Repeat the command to continue after an
    interruption. Takes minutes to hours: use --dry-run first.

    Example
    -------
    gearcase campaign plan.toml --dry-run
    scenes      240
    labels      80 chipped-tooth, 80 cracked-tooth, 80 healthy
    ...
    time        about 4 minutes on 2 cores: ...
    disk        about 144 MB in 1200 files, 5 for each simulation
    """
    from pipelines.datasets.campaign import run_campaign
    from pipelines.datasets.campaign_scenes import sampled_scenes
    from pipelines.datasets.estimate import estimate
    from pipelines.datasets.plan import load_plan
    from pipelines.datasets.workers import dask_workers, local_workers
    from pipelines.io.errors import InputError

    if options.cluster and options.scheduler:
        raise InputError("campaign: --cluster starts a scheduler, --scheduler names a running one. Delete one of them.")
    plan = load_plan(options.plan)
    if options.dry_run:
        yield estimate(plan, sampled_scenes(plan)).text
        return 0
    if options.cluster or options.scheduler:
        workers = dask_workers(options.scheduler, options.processes)
    else:
        workers = local_workers(options.processes)
    finished = run_campaign(
        plan,
        options.out or f"campaigns/{plan.name}",
        workers,
        work_of(options),
        retry=options.retry_failed,
        quiet=options.quiet,
    )
    yield from finished.lines()
    return int(finished.simulated > 0 and finished.failed == finished.simulated)
