"""Run a graph of stages: take what the cache holds, build the rest, long independent stages side by side."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from pipelines.engine.build_step import Result, build_here, one_thread, stage_record
from pipelines.engine.cache import Cache
from pipelines.engine.processes import Pool
from pipelines.engine.step import Graph, Stage, StageRecord, stored

_LONG_SECONDS = 3.0  # stages expected to take longer may go to a process of their own


class Observer(Protocol):
    """Is told what happens, for progress and logs."""

    def started(self, stage: Stage) -> None:
        """A stage is being built."""

    def finished(self, stage: Stage, record: StageRecord) -> None:
        """A stage is built or taken from the cache."""


class Silent:
    """Observes nothing."""

    def started(self, stage: Stage) -> None:
        """Nothing."""

    def finished(self, stage: Stage, record: StageRecord) -> None:
        """Nothing."""


@dataclass(frozen=True)
class Outcome:
    """All stages of a run by name."""

    results: Mapping[str, Result]

    def value(self, name: str) -> Any:
        """What the stage returned."""
        return self.results[name].load()

    @property
    def records(self) -> tuple[StageRecord, ...]:
        """Records in the order of the graph."""
        return tuple(result.record for result in self.results.values())

    def ledger(self) -> dict[str, int]:
        """Counts of all stages, each distinct result counted once, reused or not."""
        total: dict[str, int] = {}
        for record in {r.key: r for r in self.records}.values():
            for name, count in record.ledger.items():
                total[name] = total.get(name, 0) + count
        return total


def run_graph(
    graph: Graph,
    cache: Cache,
    wanted: Iterable[str],
    *,
    observer: Observer | None = None,
    processes: int | None = None,
    known: Mapping[str, Result] | None = None,
) -> Outcome:
    """Build or reuse the wanted stages and what they take.

    Parameters
    ----------
    processes : long stages built at the same time; default 2, or 1 on a single core
    known : results of stages of this graph that are at hand

    Raises
    ------
    whatever a stage raises, with the stage's name added; WorkError if a process ends without an answer.
    Finished stages stay in the cache.
    """
    wanted = set(wanted)
    graph = graph.needed(wanted)
    observer = observer or Silent()
    if processes is None:
        processes = min(2, os.cpu_count() or 1)
    results = {name: result for name, result in (known or {}).items() if name in graph.stages}
    verified: set[str] = set()
    urgency = graph.seconds_to_the_end()  # what the most must wait for starts first
    with one_thread(), Pool() as pool:
        while len(results) < len(graph.stages):
            ready = _take_what_is_cached(graph, cache, results, wanted, pool.names(), observer)
            ready = [(stage, key) for stage, key in ready if not pool.builds(key)]
            if _drop_damaged(ready, cache, results, verified):
                continue
            long = [(stage, key) for stage, key in ready if stage.seconds >= _LONG_SECONDS]
            long.sort(key=lambda one: -urgency[one[0].name])
            if processes > 1 and (len({key for _, key in long}) > 1 or (long and len(pool))):
                for stage, key in long:
                    if len(pool) < processes and not pool.builds(key):
                        observer.started(stage)
                        pool.start(stage, key, _upstream(stage, results), cache.folder)
                ready = [(stage, key) for stage, key in ready if stage.seconds < _LONG_SECONDS]
            if ready:
                stage, key = ready[0]
                observer.started(stage)
                _keep(results, stage, build_here(stage, key, _upstream(stage, results), cache), observer)
            elif len(pool):
                for stage in graph:
                    if stage.name not in results and stage.takes:
                        stage.load()  # while the children work
                for stage, result in pool.wait():
                    _keep(results, stage, result, observer)
    return Outcome({name: results[name] for name in graph.stages})


def _take_what_is_cached(
    graph: Graph, cache: Cache, results: dict[str, Result], wanted: set[str], running: set[str], observer: Observer
) -> list[tuple[Stage, str]]:
    """Move stages that need no work into `results`; the (stage, key) that are ready to be built.

    Only what is wanted is verified to the last byte now, the rest when it is read.
    """
    ready = []
    for stage in graph:
        if stage.name in results or stage.name in running or any(name not in results for name in stage.takes):
            continue
        contents = {name: results[name].record.content for name in stage.takes}
        key = stage.key(contents)
        same = next((r for r in results.values() if r.record.key == key), None)
        entry = same.entry if same else stored(stage, cache, contents, thorough=stage.name in wanted)
        if same is not None:
            record = stage_record(stage, key, _facts_of(same.record), reused=True)
            _keep(results, stage, Result(record, entry, same.value), observer)
        elif entry is not None:
            record = stage_record(stage, entry.facts["key"], entry.facts, reused=True)
            _keep(results, stage, Result(record, entry), observer)
        else:
            ready.append((stage, key))
    return ready


def _drop_damaged(ready: list[tuple[Stage, str]], cache: Cache, results: dict[str, Result], verified: set[str]) -> bool:
    """Verify stored results before stages read them; True if one was damaged and must be built again."""
    inputs = dict.fromkeys(name for stage, _ in ready for name in stage.takes if name not in verified)
    dropped = False
    for name in inputs:
        record, entry = results[name].record, results[name].entry
        if record.reused and entry is not None and cache.find(record.kind, record.key) is None:
            del results[name]
            dropped = True
        else:
            verified.add(name)
    return dropped


def _keep(results: dict[str, Result], stage: Stage, result: Result, observer: Observer) -> None:
    results[stage.name] = result
    observer.finished(stage, result.record)


def _upstream(stage: Stage, results: Mapping[str, Result]) -> dict[str, Result]:
    return {name: results[name] for name in stage.takes}


def _facts_of(record: StageRecord) -> dict[str, Any]:
    return {name: getattr(record, name) for name in ("content", "seconds", "peak_bytes", "ledger", "libraries")}
