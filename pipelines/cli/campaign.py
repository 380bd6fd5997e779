"""`gearcase campaign`: simulate every scene of a plan into one labelled data set."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Simulate what is missing and say how fast it went; 1 if every scene failed."""
    from pipelines.datasets.campaign import planned, run_campaign
    from pipelines.datasets.estimate import estimate
    from pipelines.datasets.plan import load_plan
    from pipelines.datasets.shown_progress import shown_campaign
    from pipelines.datasets.workers import dask_workers, local_workers
    from pipelines.engine.working import Work

    plan = load_plan(options.plan)
    if options.dry_run:
        sys.stdout.write(estimate(plan, planned(plan)).to_text())
        return 0
    if options.cluster or options.scheduler:
        workers = dask_workers(options.scheduler, options.processes)
    else:
        workers = local_workers(options.processes)
    with shown_campaign(quiet=options.quiet) as shown:
        finished = run_campaign(
            plan,
            options.out or f"campaigns/{plan.name}",
            workers,
            Work(processes=options.processes, quiet=options.quiet),
            retry=options.retry_failed,
            begun=shown.begun,
            told=shown.told,
        )
    sys.stdout.write("".join(f"{line}\n" for line in finished.lines()))
    return 1 if finished.simulated and finished.failed == finished.simulated else 0
