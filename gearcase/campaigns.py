"""Campaigns: a labelled data set of many scenes, sampled from a plan."""

from __future__ import annotations

import contextlib
from concurrent.futures import Executor
from pathlib import Path

from gearcase.argument_checks import checked_file
from pipelines.datasets.campaign import Finished, run_campaign
from pipelines.datasets.plan import load_plan
from pipelines.datasets.workers import Workers, local_workers
from pipelines.engine.run_graph import Work

__all__ = ["Finished", "campaign"]


def campaign(
    plan: str | Path,
    *,
    out: str | Path | None = None,
    processes: int | None = None,
    executor: Executor | None = None,
    at_once: int = 1,
) -> Finished:
    """Simulate every scene of a plan that is not in the data set yet.

    Parameters
    ----------
    plan : file of the campaign, see docs/campaigns.md
    out : folder of the data set, ./campaigns/<plan> by default
    processes : scenes computed in parallel on this machine, all cores by default
    executor : runs the scenes instead: any of `concurrent.futures`, or that of a Dask client
    at_once : number of scenes that the executor gets at a time

    Returns
    -------
    folder, number of scenes, how many were simulated now and how many of these failed

    Raises
    ------
    SceneError, InputError : the plan or the folder cannot be used
    WorkError : the disk is full, or the workers have ended; finished scenes are kept

    >>> import gearcase
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> plan = Path("few.toml")
    >>> _ = plan.write_text('''scene = "minimal"
    ... scenes = 3
    ... [variables]
    ... load = { from = 50.0, to = 100.0 }
    ... [settings]
    ... load.container_kg = "$load"
    ... simulation.end_s = 0.02
    ... ''')
    >>> done = gearcase.campaign(plan, executor=ThreadPoolExecutor(1))
    >>> done.runs, done.failed, str(done.folder)
    (3, 0, 'campaigns/few')
    """
    found = load_plan(checked_file("plan", plan, "the plan of a campaign"))
    workers = (
        local_workers(processes)
        if executor is None
        else contextlib.nullcontext(Workers(executor=executor, count=lambda: at_once))
    )
    return run_campaign(found, out or f"campaigns/{found.name}", workers, Work())
