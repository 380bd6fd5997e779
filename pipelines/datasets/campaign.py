"""Run a campaign: its folder, the first scene for the layout, then all scenes that have no row, on any workers."""

from __future__ import annotations

import itertools
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fem.processes.executor import ProcessEnded
from fem.storage import shown_html
from pipelines.datasets.campaign_scenes import SampledScene, sampled_scenes, scene_of
from pipelines.datasets.card import write_card
from pipelines.datasets.expressions import ExpressionError
from pipelines.datasets.folder import begin, disk_errors, find_begun, held, identity_facts
from pipelines.datasets.job import Job, keep, row_head, work
from pipelines.datasets.plan import Plan
from pipelines.datasets.rows import FAILED, numbers, read_rows, row_path, sweep_rows, write_table
from pipelines.datasets.signal_layout import RunLayout, run_layout
from pipelines.datasets.store import sweep
from pipelines.datasets.worker_cache import WorkerCache
from pipelines.datasets.workers import Workers, lost
from pipelines.engine.progress import reported_count
from pipelines.engine.run_graph import Work
from pipelines.engine.step import Graph
from pipelines.io.errors import InputError, SceneError, WorkError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.checks.cost import cost
from pipelines.machine.checks.cost import words as size_words
from pipelines.scene.load_scene import LoadedScene
from pipelines.steps.machine_steps import machine_steps
from pipelines.steps.motion import moved

_LAYOUT_TRIES = 20  # scenes that are looked at for one that can be run
_LAYOUT_SAMPLES = 4
_IN_FLIGHT = 2  # scenes per worker that are handed out
MOST_BYTES = 1e9  # of the signals of one run in the memory of a worker
MOST_DEATHS = 3  # of processes with one scene in them, before the scene counts as failed
_Result = tuple[dict[str, Any], Mapping[str, np.ndarray] | None]  # of `work`


@dataclass(frozen=True, kw_only=True)
class Finished:
    """A finished campaign: its scenes, those that were simulated now, those of them that failed.

    `warnings` are those of all runs of the data set, counted by kind.
    """

    folder: Path
    runs: int
    simulated: int
    failed: int
    seconds: float
    loop_seconds: float
    workers: int
    warnings: tuple[str, ...] = ()

    def _repr_html_(self) -> str:
        """The lines at the end, for a notebook."""
        return shown_html.table("Campaign", (), ((line,) for line in self.lines()))

    def lines(self) -> list[str]:
        """What the command prints at the end."""
        failed = f", {self.failed} of them failed (see the column reason of rows.parquet)" if self.failed else ""
        out = [f"{self.runs} scenes, {self.simulated} simulated now{failed}"]
        if self.simulated:
            share = self.loop_seconds / (self.seconds * self.workers)  # scenes per hour against those of the bare loop
            out.append(
                f"{3600.0 * self.simulated / self.seconds:.0f} scenes per hour with {self.workers} workers; "
                f"{100 * share:.0f} % of their time is time integration"
            )
        return [*out, *(f"warning: {text}" for text in self.warnings), f"data set: {self.folder}"]


def run_campaign(
    plan: Plan,
    out: str | Path,
    workers: AbstractContextManager[Workers],
    building: Work,
    *,
    retry: bool = False,
    quiet: bool = True,
) -> Finished:
    """Simulate every scene of a plan that has no row yet.

    Parameters
    ----------
    plan, out : the campaign and its folder
    workers : that simulate; entered when there is something to do
    building : how laws and casing of the first scene are built
    retry : simulate again what failed
    quiet : show no progress

    Raises
    ------
    SceneError, InputError : the plan, its first scenes or the folder cannot be used
    WorkError : the disk is full, or the workers are gone; what is finished is kept
    """
    sampled = sampled_scenes(plan)
    facts = identity_facts(plan, sampled)
    with held(out) as folder:
        known = find_begun(folder, facts)
        if known is None:
            first, layout = first_layout(plan, sampled, building)
            known = begin(folder, plan, first.resolved(), sampled, layout, facts), layout
        identity, layout = known
        if retry:
            for row in read_rows(folder):
                if row["status"] == FAILED:
                    row_path(folder, row["run"]).unlink()
        stored = numbers(folder)
        left = [one for one in sampled if one.run not in stored]
        start, loop, failed, count = time.perf_counter(), 0.0, 0, 0
        if left:
            jobs = (
                Job(plan=plan, layout=layout, folder=folder.absolute(), identity=identity, sample=one) for one in left
            )
            with workers as hands, reported_count("scenes", quiet=quiet) as report:
                count = hands.count()
                done = f", {len(sampled) - len(left)} already done" if len(left) < len(sampled) else ""
                board = f"; {hands.dashboard}" if hands.dashboard else ""
                report.line(f"{len(sampled)} scenes{done}; {count} workers{board}")
                report(0, len(left))
                start = time.perf_counter()
                for number, (row, arrays) in enumerate(_outcomes(jobs, hands), 1):
                    if arrays is not None:
                        with disk_errors(folder):
                            keep(folder, row, arrays)
                    loop += row.get("loop_seconds", 0.0)
                    if row["status"] == FAILED:
                        failed += 1
                        report.line(f"scene {row['run']} failed: {row['reason']}")
                    report(number, len(left), failed)
            sweep(folder)
            sweep_rows(folder)
        seconds = time.perf_counter() - start
        with disk_errors(folder):
            write_table(folder)
            warnings = write_card(folder).warnings
    return Finished(
        folder=folder,
        runs=len(sampled),
        simulated=len(left),
        failed=failed,
        seconds=seconds,
        loop_seconds=loop,
        workers=max(1, count),
        warnings=warnings,
    )


def first_layout(plan: Plan, sampled: Sequence[SampledScene], building: Work) -> tuple[LoadedScene, RunLayout]:
    """The first scene that can be run, and the layout of its signals, from a motion of a few samples.

    Raises
    ------
    SceneError, ExpressionError : none of the first scenes can be run: what is wrong with the first one
    InputError : one run does not fit into the memory of a worker, where it is until it is stored
    """
    failure: SceneError | ExpressionError | None = None
    for one in sampled[:_LAYOUT_TRIES]:
        try:
            loaded = scene_of(plan, one.values)
            machine = checked_machine(loaded.scene, loaded.source.shown)
        except (SceneError, ExpressionError) as error:
            failure = failure or error
            continue
        size = cost(machine).bytes
        if size > MOST_BYTES:
            raise InputError(
                f"one run of {loaded.name} holds {size_words(size)} in memory, limit {size_words(MOST_BYTES)} in a "
                "campaign. Reduce simulation.end_s or simulation.output_rate_Hz, or divide the motion into several "
                "scenes."
            )
        graph = Graph(machine_steps(machine))
        building.build(graph, graph.steps["simulate"].inputs)
        given = machine.motion
        few = replace(given, end=_LAYOUT_SAMPLES / given.output_rate)
        motion = moved(WorkerCache(building.cache).system(machine), few)
        return loaded, run_layout(motion, round(given.end * given.output_rate), plan.table.signals)
    assert failure is not None
    raise failure


def _outcomes(jobs: Iterator[Job], workers: Workers) -> Iterator[_Result]:
    """The scenes as they are done, a few of them handed out at a time.

    A scene whose process dies is simulated again, a few times.
    """
    executor = workers.executor
    running: dict[Future[_Result], Job] = {}
    deaths: Counter[int] = Counter()
    try:
        while True:
            for job in itertools.islice(jobs, max(0, _IN_FLIGHT * workers.count() - len(running))):
                running[executor.submit(work, job)] = job
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                job = running.pop(future)
                try:
                    yield future.result()
                except ProcessEnded:
                    deaths[job.sample.run] += 1
                    if deaths[job.sample.run] == MOST_DEATHS:
                        yield _killed(job)
                    else:
                        running[executor.submit(work, job)] = job
                except Exception as error:
                    if type(error).__name__ == "KilledWorker":  # of Dask, after it has tried as often on other workers
                        yield _killed(job)
                    elif isinstance(error, OSError) and error.errno is not None:
                        raise WorkError(
                            f"scene {job.sample.run}: {error}. Finished scenes are kept. Correct the cause and repeat "
                            "the command."
                        ) from error
                    else:
                        raise lost(error) from error
    except CancelledError as error:
        raise lost(error) from error
    finally:
        for future in running:
            future.cancel()


def _killed(job: Job) -> _Result:
    """The row of a scene whose process died again and again."""
    reason = f"the process ended without a result {MOST_DEATHS} times, perhaps for lack of memory. Reduce --processes."
    return row_head(job, FAILED, reason), {}
