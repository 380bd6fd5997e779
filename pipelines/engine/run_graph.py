"""Run of a graph of steps: use stored results, and build the others, long independent steps in parallel processes."""

from __future__ import annotations

import contextlib
import functools
import importlib
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
from pipelines.engine.build_step import Event, Result, build_here, one_thread, step_record
from pipelines.engine.cache import Cache
from pipelines.engine.progress import ProgressFunction, reported_steps
from pipelines.engine.step import LONG_SECONDS, Graph, Step, StepRecord, seconds_to_the_end, stored
from pipelines.io.errors import WorkError

_LOG = logging.getLogger(__name__)
_WORTH_SENDING = 0.3  # s, shortest step that a waiting child builds
_HELD_BYTES = 16e6  # a larger result is not kept in memory, but read from the cache when it is needed

Ready = list[tuple[Step, str]]  # steps that can be built, with their keys


@dataclass(frozen=True)
class Outcome:
    """Results of all steps of a run by name."""

    results: Mapping[str, Result]

    def value(self, name: str) -> Any:
        """Result of a step."""
        return self.results[name].load()

    @property
    def records(self) -> tuple[StepRecord, ...]:
        """Records in the order of the graph."""
        return tuple(result.record for result in self.results.values())

    def ledger(self) -> dict[str, int]:
        """Counts of all steps, reused or not; equal results are counted once."""
        total: dict[str, int] = {}
        for record in {r.key: r for r in self.records}.values():
            for name, count in record.ledger.items():
                total[name] = total.get(name, 0) + count
        return total


def run_graph(
    graph: Graph,
    cache: Cache,
    requested: Iterable[str],
    *,
    on_event: Callable[[Event], None] = lambda event: None,
    processes: int | None = None,
    known: Mapping[str, Result] | None = None,
) -> Outcome:
    """Build or reuse steps and their inputs.

    Parameters
    ----------
    graph, cache : the steps, and the cache of their results
    requested : names of the steps
    on_event : called with the events of all steps
    processes : number of long steps that are built at the same time; default 2, or 1 on a single core
    known : results of steps of this graph that are in memory

    Raises
    ------
    any error of a step, with the name of the step added; WorkError if a process ends without a result. Finished steps
    stay in the cache. If a short step fails while long ones are being built, those are finished first.
    """
    return _Run(graph, cache, set(requested), on_event, process_count(processes), known or {}).outcome()


@dataclass(frozen=True, kw_only=True)
class Work:
    """Executor of graphs: number of `processes` (see `run_graph`), progress output unless `quiet`, callback, cache."""

    processes: int | None = None
    quiet: bool = True
    progress: ProgressFunction | None = None
    cache: Cache = field(default_factory=Cache)

    def build(
        self,
        graph: Graph,
        requested: Iterable[str],
        on_result: Callable[[Step, Result], None] = lambda step, result: None,
    ) -> Outcome:
        """Build or reuse steps and their inputs; `on_result` is called with each of them."""
        requested = tuple(requested)
        processes = process_count(self.processes)
        steps = graph.needed(requested)
        with reported_steps(steps, self.cache, processes, quiet=self.quiet, on_progress=self.progress) as report:

            def on_event(event: Event) -> None:
                report(event)
                if event.result is not None:
                    on_result(event.step, event.result)

            return run_graph(steps, self.cache, requested, on_event=on_event, processes=processes)


class _Run:
    """State of a run: the results so far, and the steps that are being built.

    Long steps are built in child processes (`_in_children`) if two can run at the same time. One short step at a time
    is built in a thread (`_in_thread`) at the same time, also next to another short one. All others are built in the
    main thread.
    """

    def __init__(
        self,
        graph: Graph,
        cache: Cache,
        requested: set[str],
        on_event: Callable[[Event], None],
        processes: int,
        known: Mapping[str, Result],
    ) -> None:
        self._graph, self._cache, self._requested, self._on_event = graph.needed(requested), cache, requested, on_event
        self._processes = processes
        self._results = {name: result for name, result in known.items() if name in self._graph.steps}
        self._errors: list[Exception] = []
        self._news: list[Event] = []  # results of which the caller does not know
        self._verified: set[str] = set()
        # the step with the longest chain of waiting steps starts first
        self._urgency = seconds_to_the_end((step.name, step.seconds, step.inputs) for step in self._graph)
        self._awaited = self._graph.needed(step.name for step in self._graph if step.seconds >= LONG_SECONDS).steps
        self._prepared: dict[tuple[str, ...], Future] = {}  # by `_code` of a step: its preparation
        self._in_children: dict[str, str] = {}  # keys of the steps in child processes, by name
        self._in_thread: dict[str, str] = {}  # key of the short step in a thread, by name
        self._imported: set[str] = set()  # modules that a waiting child process was told to import
        self._events: queue.SimpleQueue[tuple[Step, Future | float]] = queue.SimpleQueue()

    def outcome(self) -> Outcome:
        """Build everything; results in the order of the graph."""
        with one_thread(), Processes(self._processes) as children:
            while any(name not in self._results for name in self._graph.steps):
                while not self._events.empty():
                    self._take_event()
                at_work = {*self._in_children.values(), *self._in_thread.values()}
                ready = [(step, key) for step, key in self._reuse() if key not in at_work]
                if self._drop_damaged(ready):
                    continue
                ready = self._start_in_children(ready, children)
                self._announce()
                if self._in_children:
                    self._prepare()
                if self._in_children or (len(ready) > 1 and self._processes > 1):
                    ready = self._start_in_thread(ready)
                if ready:
                    self._build(*ready[0], children)
                elif self._in_children or self._in_thread:
                    later = [step for step in self._graph if step.name not in self._results and step.inputs]
                    modules = {module for step in later for module in step.modules}
                    if children.idle and not modules <= self._imported:
                        self._imported |= modules
                        children.submit(_import_modules, modules)
                    for step in later:
                        step.load()  # import modules while the child processes build
                    self._take_event()
            self._announce()
        if self._errors:
            raise self._errors[0]
        return Outcome({name: self._results[name] for name in self._graph.steps})

    def _reuse(self) -> Ready:
        """Add known and stored results; the steps that can be built now.

        The files of requested steps are verified now, those of other steps before they are read.
        """
        ready, at_work = [], self._in_children.keys() | self._in_thread.keys()
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
            entry = None if same else stored(step, self._cache, contents, thorough=step.name in self._requested)
            if same is not None:
                self._keep(step, replace(same, record=replace(same.record, name=step.name, reused=True)))
            elif entry is not None:
                self._keep(step, Result(step_record(step, entry.facts["key"], entry.facts, reused=True), entry))
            else:
                ready.append((step, key))
        return ready

    def _drop_damaged(self, ready: Ready) -> bool:
        """Verify stored results before steps read them; True if one is damaged and must be built again."""
        dropped = False
        for name in dict.fromkeys(name for step, _ in ready for name in step.inputs if name not in self._verified):
            record, entry = self._results[name].record, self._results[name].entry
            if record.reused and entry is not None and self._cache.find(record.kind, record.key) is None:
                del self._results[name]
                dropped = True
            else:
                self._verified.add(name)
        return dropped

    def _start_in_children(self, ready: Ready, children: Processes) -> Ready:
        """Start long steps in child processes if two can run at the same time; the steps to build here.

        If children wait while a short step is built in the thread, they build other short steps.
        """
        long = [(step, key) for step, key in ready if step.seconds >= LONG_SECONDS]
        if not long and self._in_thread and not self._in_children and children.idle:
            long = [(step, key) for step, key in ready if step.seconds >= _WORTH_SENDING]
        elif len({key for _, key in long}) < 2 and not (long and self._in_children):
            return ready
        if self._processes < 2:
            return ready
        for step, key in sorted(long, key=lambda one: -self._urgency[one[0].name]):
            if len(self._in_children) < self._processes and key not in self._in_children.values():
                self._on_event(Event(step))
                self._in_children[step.name] = key
                upstream = {name: result.stored() for name, result in self._upstream(step).items()}
                job = pickle.dumps((step, key, upstream, self._cache.folder))
                put = functools.partial(self._put, step)
                children.listened(put, _build_in_child, job).add_done_callback(put)
        return [one for one in ready if one not in long]

    def _prepare(self) -> None:
        """Start to compile the code of later steps, once for all that call the same; most steps are shorter."""
        for step in self._graph:
            waiting = step.name not in self._results and _code(step) not in self._prepared
            if step.prepare and waiting and self._results.keys() >= {*step.prepare_takes}:
                taken = [self._results[name] for name in step.prepare_takes]
                self._prepared[_code(step)] = in_thread(_run_preparation, step, taken)

    def _start_in_thread(self, ready: Ready) -> Ready:
        """Start one short step in a thread if no long step waits for it; the steps that are left for the main thread.

        These are the ones for which long steps wait and, with no child at work, all others.
        """
        spare = [(step, key) for step, key in ready if step.name not in self._awaited]
        if spare and not self._in_thread:
            step, key = max(spare, key=lambda one: self._urgency[one[0].name])
            self._on_event(Event(step))
            self._in_thread[step.name] = key
            made = in_thread(build_here, step, key, self._upstream(step), self._cache)
            made.add_done_callback(functools.partial(self._put, step))
        at_work = self._in_thread.values()
        return [one for one in ready if one[0].name in self._awaited or not (self._in_children or one[1] in at_work)]

    def _build(self, step: Step, key: str, children: Processes) -> None:
        """Build a step in this thread."""
        self._on_event(Event(step))
        if _code(step) in self._prepared:
            wait([self._prepared[_code(step)]])
        started = {*self._results, *self._in_children, step.name}
        if not any(other.seconds >= LONG_SECONDS for other in self._graph if other.name not in started):
            children.end_idle()
        with listening(lambda share: self._on_event(Event(step, share))):
            result = build_here(step, key, self._upstream(step), self._cache)
        self._keep(step, result)

    def _put(self, step: Step, event: Future | float) -> None:
        self._events.put((step, event))

    def _take_event(self) -> None:
        """Process the share, result or error of a step in a child process or thread."""
        step, event = self._next_event()
        if isinstance(event, float):
            self._on_event(Event(step, event))
            return
        child = self._in_children.pop(step.name, None)
        self._in_thread.pop(step.name, None)
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
        """The next event. The wait has a timeout, since an interrupt would not end it on some systems."""
        while True:
            with contextlib.suppress(queue.Empty):
                return self._events.get(timeout=1.0)

    def _keep(self, step: Step, result: Result) -> None:
        large = result.entry is not None and result.entry.bytes > _HELD_BYTES
        self._results[step.name] = result.stored() if large else result
        self._news.append(Event(step, result=self._results[step.name]))

    def _announce(self) -> None:
        """Call back with the new results, after the steps that they allow were started: the caller may take seconds."""
        while self._news:
            self._on_event(self._news.pop(0))

    def _upstream(self, step: Step) -> dict[str, Result]:
        return {name: self._results[name] for name in step.inputs}


def _import_modules(modules: Iterable[str]) -> None:
    for module in modules:
        importlib.import_module(module)


def _code(step: Step) -> tuple[str, ...]:
    """The compiled code that a step calls."""
    return *step.modules, *step.compiles


def _run_preparation(step: Step, taken: list[Result]) -> None:
    """Run the preparation of a step."""
    assert step.prepare is not None
    try:
        step.prepare(step.spec, *(result.load() for result in taken))
    except Exception as error:  # the build raises the same error
        _LOG.debug("step %s, preparation failed: %s", step.name, error)


def _build_in_child(job: bytes) -> Result:
    """Build the step of a job in a child process; a failing import is raised as a WorkError."""
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
    """Number of long steps that are built at the same time: as given, or 2, or 1 on a single core."""
    return min(2, os.cpu_count() or 1) if processes is None else processes
