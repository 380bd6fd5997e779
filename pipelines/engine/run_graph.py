"""Run a graph of steps: take what the cache holds, build the rest, long independent steps side by side."""

from __future__ import annotations

import contextlib
import functools
import logging
import os
import pickle
import queue
import signal
from collections.abc import Collection, Iterable, Mapping
from concurrent.futures import Future, wait
from dataclasses import dataclass
from typing import Any, Protocol

from fem.processes.executor import ProcessEnded, Processes, RemoteError, in_thread, listening
from pipelines.engine.build_step import Result, build_here, one_thread, step_record
from pipelines.engine.cache import Cache
from pipelines.engine.step import Graph, Step, StepRecord, stored
from pipelines.io.errors import WorkError

_LOG = logging.getLogger(__name__)
_HELD_BYTES = 16e6  # a larger result is not held in memory: who needs it reads it from the cache
LONG_SECONDS = 3.0  # steps expected to take longer may go to a process of their own


class Observer(Protocol):
    """Is told what happens, for progress and logs."""

    def started(self, step: Step) -> None:
        """A step is being built."""

    def advanced(self, step: Step, share: float) -> None:
        """This share (0 to 1) of a step that tells it is done."""

    def finished(self, step: Step, result: Result) -> None:
        """A step is built or taken from the cache."""


class Silent:
    """Observes nothing."""

    def started(self, step: Step) -> None:
        """Nothing."""

    def advanced(self, step: Step, share: float) -> None:
        """Nothing."""

    def finished(self, step: Step, result: Result) -> None:
        """Nothing."""


@dataclass(frozen=True)
class Outcome:
    """All steps of a run by name."""

    results: Mapping[str, Result]

    def value(self, name: str) -> Any:
        """What the step returned."""
        return self.results[name].load()

    @property
    def records(self) -> tuple[StepRecord, ...]:
        """Records in the order of the graph."""
        return tuple(result.record for result in self.results.values())

    def ledger(self) -> dict[str, int]:
        """Counts of all steps, each distinct result counted once, reused or not."""
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
    """Build or reuse the wanted steps and what they take.

    Parameters
    ----------
    graph, cache : the steps, and where their results are stored
    wanted : names of steps
    observer : is told of every step; None: nobody
    processes : long steps built at the same time; default 2, or 1 on a single core
    known : results of steps of this graph that are at hand

    Raises
    ------
    whatever a step raises, with the step's name added; WorkError if a process ends without an answer. Finished steps
    stay in the cache. A short step that fails while long ones are at work does not stop those.
    """
    wanted = set(wanted)
    graph = graph.needed(wanted)
    observer = observer or Silent()
    processes = side_by_side(processes)
    results = {name: result for name, result in (known or {}).items() if name in graph.steps}
    errors: list[Exception] = []
    verified: set[str] = set()
    urgency = graph.seconds_to_the_end()  # what the most must wait for starts first
    awaited = graph.needed(step.name for step in graph if step.seconds >= LONG_SECONDS).steps
    prepared: dict[str, Future] = {}  # by step: its own work ahead of its turn
    away: dict[str, str] = {}  # keys of the steps in children, by name
    beside: dict[str, str] = {}  # key of the short step in a thread, by name
    events: queue.SimpleQueue[tuple[Step, Future | float]] = queue.SimpleQueue()

    def take(step: Step, event: Future | float) -> None:
        """What a step that is built elsewhere has to say: its share, its result, or its error."""
        nonlocal graph
        if isinstance(event, float):
            observer.advanced(step, event)
            return
        child = away.pop(step.name, None)
        beside.pop(step.name, None)
        try:
            _keep(results, step, event.result(), observer)
        except ProcessEnded as ended:
            raise _lost(step, ended.code) from ended
        except RemoteError as error:
            raise WorkError(str(error)) from error
        except Exception as error:
            if child is not None:
                raise
            errors.append(error)
            graph = graph.without(step.name)

    with one_thread(), Processes(processes) as children:
        while any(name not in results for name in graph.steps):
            while not events.empty() or (beside and not away):
                take(*_next(events))
            at_work = away | beside
            ready = _take_what_is_cached(graph, cache, results, wanted, at_work.keys(), observer)
            ready = [(step, key) for step, key in ready if key not in away.values()]
            if _drop_damaged(ready, cache, results, verified):
                continue
            long = [(step, key) for step, key in ready if step.seconds >= LONG_SECONDS]
            long.sort(key=lambda one: -urgency[one[0].name])
            if processes > 1 and (len({key for _, key in long}) > 1 or (long and away)):
                for step, key in long:
                    if len(away) < processes and key not in away.values():
                        observer.started(step)
                        away[step.name] = key
                        stored_inputs = {name: result.stored() for name, result in _upstream(step, results).items()}
                        job = pickle.dumps((step, key, stored_inputs, cache.folder))
                        made = children.listened(functools.partial(_put, events, step), _build_in_child, job)
                        made.add_done_callback(functools.partial(_put, events, step))
                ready = [(step, key) for step, key in ready if step.seconds < LONG_SECONDS]
            if away:
                for step in graph:
                    if step.ahead and step.name not in {*results, *prepared} and results.keys() >= {*step.ahead_takes}:
                        taken = [results[name] for name in step.ahead_takes]
                        prepared[step.name] = in_thread(_prepare, step, taken)
                spare = [(step, key) for step, key in ready if step.name not in awaited]
                if spare and not beside:
                    step, key = spare[0]
                    observer.started(step)
                    beside[step.name] = key
                    made = in_thread(build_here, step, key, _upstream(step, results), cache)
                    made.add_done_callback(functools.partial(_put, events, step))
                ready = [(step, key) for step, key in ready if step.name in awaited]
            if ready:
                step, key = ready[0]
                observer.started(step)
                if step.name in prepared:
                    wait([prepared[step.name]])
                started = {*results, *away, step.name}
                if not any(other.seconds >= LONG_SECONDS for other in graph if other.name not in started):
                    children.end_idle()
                with listening(functools.partial(observer.advanced, step)):
                    result = build_here(step, key, _upstream(step, results), cache)
                _keep(results, step, result, observer)
            elif away:
                for step in graph:
                    if step.name not in results and step.inputs:
                        step.load()  # while the children work
                take(*_next(events))
    if errors:
        raise errors[0]
    return Outcome({name: results[name] for name in graph.steps})


def _put(events: queue.SimpleQueue, step: Step, event: Future | float) -> None:
    events.put((step, event))


def _next(events: queue.SimpleQueue) -> tuple[Step, Future | float]:
    """The next event; the wait is cut, so that an interrupt is noticed on every system."""
    while True:
        with contextlib.suppress(queue.Empty):
            return events.get(timeout=1.0)


def _prepare(step: Step, taken: list[Result]) -> None:
    """The work of a step ahead of its turn; compiling takes longer than most steps."""
    assert step.ahead is not None
    try:
        step.ahead(step.spec, *(result.load() for result in taken))
    except Exception as error:  # the build itself says what is wrong
        _LOG.debug("step %s, preparation failed: %s", step.name, error)


def _build_in_child(job: bytes) -> Result:
    """Build the step of a job; what cannot be imported for it is an error like any other."""
    try:
        step, key, upstream, cache_folder = pickle.loads(job)
    except ImportError as error:
        raise WorkError(
            f"a child process cannot import {error.name or 'a module'} ({error}). Modules in the working folder "
            "and in that of the script are not found there. Run again with processes = 1 (--processes 1)."
        ) from error
    return build_here(step, key, upstream, Cache(cache_folder)).stored()


def _lost(step: Step, code: int) -> WorkError:
    if code < 0:
        how = f"was killed by signal {signal.Signals(-code).name}, possibly because memory ran out"
    else:
        how = f"ended with exit code {code} and no result; its output is printed above"
    return WorkError(
        f"step {step.name}: its process {how}. Repeat the command with --processes 1, or choose a coarser preset."
    )


def side_by_side(processes: int | None) -> int:
    """Number of long steps that are built at the same time: as asked, else 2, or 1 on a single core."""
    return min(2, os.cpu_count() or 1) if processes is None else processes


def _take_what_is_cached(
    graph: Graph,
    cache: Cache,
    results: dict[str, Result],
    wanted: set[str],
    running: Collection[str],
    observer: Observer,
) -> list[tuple[Step, str]]:
    """Move steps that need no work into `results`; the (step, key) that are ready to be built.

    Only what is wanted is verified to the last byte now, the rest when it is read.
    """
    ready = []
    for step in graph:
        if step.name in results or step.name in running or any(name not in results for name in step.inputs):
            continue
        contents = {name: results[name].record.content for name in step.inputs}
        key = step.key(contents)
        same = next((r for r in results.values() if r.record.key == key), None)
        entry = same.entry if same else stored(step, cache, contents, thorough=step.name in wanted)
        if same is not None:
            record = step_record(step, key, _facts_of(same.record), reused=True)
            _keep(results, step, Result(record, entry, same.value), observer)
        elif entry is not None:
            record = step_record(step, entry.facts["key"], entry.facts, reused=True)
            _keep(results, step, Result(record, entry), observer)
        else:
            ready.append((step, key))
    return ready


def _drop_damaged(ready: list[tuple[Step, str]], cache: Cache, results: dict[str, Result], verified: set[str]) -> bool:
    """Verify stored results before steps read them; True if one was damaged and must be built again."""
    inputs = dict.fromkeys(name for step, _ in ready for name in step.inputs if name not in verified)
    dropped = False
    for name in inputs:
        record, entry = results[name].record, results[name].entry
        if record.reused and entry is not None and cache.find(record.kind, record.key) is None:
            del results[name]
            dropped = True
        else:
            verified.add(name)
    return dropped


def _keep(results: dict[str, Result], step: Step, result: Result, observer: Observer) -> None:
    large = result.entry is not None and result.entry.bytes > _HELD_BYTES
    results[step.name] = result.stored() if large else result
    observer.finished(step, results[step.name])


def _upstream(step: Step, results: Mapping[str, Result]) -> dict[str, Result]:
    return {name: results[name] for name in step.inputs}


def _facts_of(record: StepRecord) -> dict[str, Any]:
    return {name: getattr(record, name) for name in ("content", "seconds", "peak_bytes", "ledger", "libraries")}
