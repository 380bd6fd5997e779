"""`gearcase campaign`: simulate every scene of a plan into one labelled data set."""

from __future__ import annotations

import argparse

from pipelines.cli.command_line import Printed, quiet_argument, work_of
from pipelines.io.argument_types import count, path

HELP = """\
Simulate all scenes of a plan and write them as one labelled data set. Repeat the command to continue after an
interruption. Takes minutes to hours: use --dry-run first."""
EXAMPLE = """\
gearcase campaign plan.toml --dry-run
scenes      240
labels      80 chipped-tooth, 80 cracked-tooth, 80 healthy
...
time        about 4 minutes on 2 cores: ...
disk        about 144 MB in 1200 files, 5 for each simulation"""


def arguments(sub: argparse.ArgumentParser) -> None:
    """Add the arguments: a plan, the folder of the data set, and the processes that simulate."""
    sub.add_argument("plan", metavar="PLAN", type=path, help="plan of the campaign, a file that ends in .toml")
    sub.add_argument("--out", metavar="FOLDER", type=path, help="folder of the data set (default: ./campaigns/<plan>)")
    sub.add_argument(
        "--dry-run", action="store_true", help="print number of runs, time and disk space, and simulate nothing"
    )
    sub.add_argument(
        "--processes", type=count, metavar="N", help="scenes simulated at the same time (default: number of cores)"
    )
    where = sub.add_mutually_exclusive_group()
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="address of a running Dask scheduler, or its scheduler file"
    )
    where.add_argument("--cluster", action="store_true", help="start a local Dask scheduler with a dashboard")
    sub.add_argument("--retry-failed", action="store_true", help="simulate failed runs again")
    quiet_argument(sub)


def main(options: argparse.Namespace) -> Printed:
    """Simulate the scenes that are missing and print a summary; 1 if every scene failed."""
    from pipelines.datasets.campaign import run_campaign
    from pipelines.datasets.campaign_scenes import sampled_scenes
    from pipelines.datasets.estimate import estimate
    from pipelines.datasets.plan import load_plan
    from pipelines.datasets.workers import dask_workers, local_workers

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
