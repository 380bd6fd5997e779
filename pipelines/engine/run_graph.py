"""Run a graph of steps: take what the cache holds, build the rest, long independent steps side by side."""

from __future__ import annotations

import contextlib
import functools
import logging
import os
import pickle
import queue
import signal
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future, wait
from dataclasses import dataclass, field, replace
from typing import Any

from fem.processes.executor import ProcessEnded, Processes, RemoteError, in_thread, listening
from pipelines.engine.build_step import LONG_SECONDS, Event, Result, build_here, one_thread, step_record
from pipelines.engine.cache import Cache
from pipelines.engine.progress import ProgressFunction, reported_steps
from pipelines.engine.step import Graph, Step, StepRecord, seconds_to_the_end, stored
from pipelines.io.errors import WorkError

_LOG = logging.getLogger(__name__)
_HELD_BYTES = 16e6  # a larger result is not held in memory: who needs it reads it from the cache

Ready = list[tuple[Step, str]]  # steps that can be built, with their keys


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
    on_event: Callable[[Event], None] = lambda event: None,
    processes: int | None = None,
    known: Mapping[str, Result] | None = None,
) -> Outcome:
    """Build or reuse steps and what they take.

    Parameters
    ----------
    graph, cache : the steps, and where their results are stored
    wanted : names of the steps
    on_event : called with what happens to every step
    processes : long steps built at the same time; default 2, or 1 on a single core
    known : results of steps of this graph that are at hand

    Raises
    ------
    whatever a step raises, with the step's name added; WorkError if a process ends without an answer. Finished steps
    stay in the cache. A short step that fails while long ones are at work does not stop those.
    """
    return _Run(graph, cache, set(wanted), on_event, process_count(processes), known or {}).outcome()


@dataclass(frozen=True, kw_only=True)
class Work:
    """`processes` long steps are built side by side (None: 2, or 1 on a single core); `progress` is called for each."""

    processes: int | None = None
    quiet: bool = True
    progress: ProgressFunction | None = None
    cache: Cache = field(default_factory=Cache)

    def build(
        self, graph: Graph, wanted: Iterable[str], on_result: Callable[[Step, Result], None] = lambda step, result: None
    ) -> Outcome:
        """Some steps and what they take, from the cache or built; `on_result` is called with each of them."""
        wanted = tuple(wanted)
        processes = process_count(self.processes)
        steps = graph.needed(wanted)
        with reported_steps(steps, self.cache, processes, quiet=self.quiet, on_progress=self.progress) as report:

            def on_event(event: Event) -> None:
                report(event)
                if event.result is not None:
                    on_result(event.step, event.result)

            return run_graph(steps, self.cache, wanted, on_event=on_event, processes=processes)


class _Run:
    """The state of a run: the results so far, and what is at work.

    Long steps are built in child processes (`_away`) where two of them can be, one short step in a thread at the same
    time (`_beside`), and all others here. Without children at work the thread takes one of several short steps, too.
    """

    def __init__(
        self,
        graph: Graph,
        cache: Cache,
        wanted: set[str],
        on_event: Callable[[Event], None],
        processes: int,
        known: Mapping[str, Result],
    ) -> None:
        self._graph, self._cache, self._wanted, self._on_event = graph.needed(wanted), cache, wanted, on_event
        self._processes = processes
        self._results = {name: result for name, result in known.items() if name in self._graph.steps}
        self._errors: list[Exception] = []
        self._verified: set[str] = set()
        # what the most must wait for starts first
        self._urgency = seconds_to_the_end((step.name, step.seconds, step.inputs) for step in self._graph)
        self._awaited = self._graph.needed(step.name for step in self._graph if step.seconds >= LONG_SECONDS).steps
        self._prepared: dict[str, Future] = {}  # by step: its own work ahead of its turn
        self._away: dict[str, str] = {}  # keys of the steps in children, by name
        self._beside: dict[str, str] = {}  # key of the short step in a thread, by name
        self._events: queue.SimpleQueue[tuple[Step, Future | float]] = queue.SimpleQueue()

    def outcome(self) -> Outcome:
        """Build everything; the results in the order of the graph."""
        with one_thread(), Processes(self._processes) as children:
            while any(name not in self._results for name in self._graph.steps):
                while not self._events.empty():
                    self._take_event()
                at_work = {*self._away.values(), *self._beside.values()}
                ready = [(step, key) for step, key in self._reuse() if key not in at_work]
                if self._drop_damaged(ready):
                    continue
                ready = self._send_away(ready, children)
                if self._away:
                    self._prepare()
                if self._away or (len(ready) > 1 and self._processes > 1):
                    ready = self._start_beside(ready)
                if ready:
                    self._build(*ready[0], children)
                elif self._away or self._beside:
                    for step in self._graph:
                        if step.name not in self._results and step.inputs:
                            step.load()  # while the children work
                    self._take_event()
        if self._errors:
            raise self._errors[0]
        return Outcome({name: self._results[name] for name in self._graph.steps})

    def _reuse(self) -> Ready:
        """Move steps that need no work into the results; those that are ready to be built.

        Only the steps of `run_graph` are verified to the last byte now, the rest when it is read.
        """
        ready, at_work = [], self._away.keys() | self._beside.keys()
        for step in self._graph:
            if (
                step.name in self._results
                or step.name in at_work
                or any(name not in self._results for name in step.inputs)
            ):
                continue
            contents = {name: self._results[name].record.content for name in step.inputs}
            key = step.key(contents)
            same = next((result for result in self._results.values() if result.record.key == key), None)
            entry = None if same else stored(step, self._cache, contents, thorough=step.name in self._wanted)
            if same is not None:
                self._keep(step, replace(same, record=replace(same.record, name=step.name, reused=True)))
            elif entry is not None:
                self._keep(step, Result(step_record(step, entry.facts["key"], entry.facts, reused=True), entry))
            else:
                ready.append((step, key))
        return ready

    def _drop_damaged(self, ready: Ready) -> bool:
        """Verify stored results before steps read them; True if one was damaged and must be built again."""
        dropped = False
        for name in dict.fromkeys(name for step, _ in ready for name in step.inputs if name not in self._verified):
            record, entry = self._results[name].record, self._results[name].entry
            if record.reused and entry is not None and self._cache.find(record.kind, record.key) is None:
                del self._results[name]
                dropped = True
            else:
                self._verified.add(name)
        return dropped

    def _send_away(self, ready: Ready, children: Processes) -> Ready:
        """Give long steps to children if two can be at work at the same time; the others are built here."""
        long = [(step, key) for step, key in ready if step.seconds >= LONG_SECONDS]
        alone = len({key for _, key in long}) < 2 and not (long and self._away)
        if self._processes < 2 or alone:
            return ready
        for step, key in sorted(long, key=lambda one: -self._urgency[one[0].name]):
            if len(self._away) < self._processes and key not in self._away.values():
                self._on_event(Event(step))
                self._away[step.name] = key
                upstream = {name: result.stored() for name, result in self._upstream(step).items()}
                job = pickle.dumps((step, key, upstream, self._cache.folder))
                put = functools.partial(self._put, step)
                children.listened(put, _build_in_child, job).add_done_callback(put)
        return [(step, key) for step, key in ready if step.seconds < LONG_SECONDS]

    def _prepare(self) -> None:
        """Begin what steps can do before their turn: compiling takes longer than most steps."""
        for step in self._graph:
            waiting = step.name not in {*self._results, *self._prepared}
            if step.ahead and waiting and self._results.keys() >= {*step.ahead_takes}:
                taken = [self._results[name] for name in step.ahead_takes]
                self._prepared[step.name] = in_thread(_work_ahead, step, taken)

    def _start_beside(self, ready: Ready) -> Ready:
        """Build one short step that no long one waits for in a thread; those that are left to be built here.

        These are the ones that long steps wait for and, with no child at work, all others.
        """
        spare = [(step, key) for step, key in ready if step.name not in self._awaited]
        if spare and not self._beside:
            step, key = spare[0]
            self._on_event(Event(step))
            self._beside[step.name] = key
            made = in_thread(build_here, step, key, self._upstream(step), self._cache)
            made.add_done_callback(functools.partial(self._put, step))
        at_work = self._beside.values()
        return [one for one in ready if one[0].name in self._awaited or not (self._away or one[1] in at_work)]

    def _build(self, step: Step, key: str, children: Processes) -> None:
        """Build a step in this thread."""
        self._on_event(Event(step))
        if step.name in self._prepared:
            wait([self._prepared[step.name]])
        started = {*self._results, *self._away, step.name}
        if not any(other.seconds >= LONG_SECONDS for other in self._graph if other.name not in started):
            children.end_idle()
        with listening(lambda share: self._on_event(Event(step, share))):
            result = build_here(step, key, self._upstream(step), self._cache)
        self._keep(step, result)

    def _put(self, step: Step, event: Future | float) -> None:
        self._events.put((step, event))

    def _take_event(self) -> None:
        """The share, the result or the error of a step that is built elsewhere."""
        step, event = self._next_event()
        if isinstance(event, float):
            self._on_event(Event(step, event))
            return
        child = self._away.pop(step.name, None)
        self._beside.pop(step.name, None)
        try:
            self._keep(step, event.result())
        except ProcessEnded as ended:
            raise _lost(step, ended.code) from ended
        except RemoteError as error:
            raise WorkError(str(error)) from error
        except Exception as error:
            if child is not None:
                raise
            self._errors.append(error)
            self._graph = self._graph.without(step.name)

    def _next_event(self) -> tuple[Step, Future | float]:
        """The next event; the wait is cut, so that an interrupt is noticed on every system."""
        while True:
            with contextlib.suppress(queue.Empty):
                return self._events.get(timeout=1.0)

    def _keep(self, step: Step, result: Result) -> None:
        large = result.entry is not None and result.entry.bytes > _HELD_BYTES
        self._results[step.name] = result.stored() if large else result
        self._on_event(Event(step, result=self._results[step.name]))

    def _upstream(self, step: Step) -> dict[str, Result]:
        return {name: self._results[name] for name in step.inputs}


def _work_ahead(step: Step, taken: list[Result]) -> None:
    """What a step can do before its turn."""
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


def process_count(processes: int | None) -> int:
    """Number of long steps that are built at the same time: as given, else 2, or 1 on a single core."""
    return min(2, os.cpu_count() or 1) if processes is None else processes
