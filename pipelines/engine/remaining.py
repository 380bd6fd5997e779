"""Remaining time of a run: its schedule is simulated with the expected seconds of each step.

The expected time is that of a step of the same kind which was built before on this machine, otherwise the estimate of
the step. Compiling code is a separate task, for which the steps that call the code wait. Expected times are scaled by
the ratio of actual to expected time of the finished steps of the same kind, or of all finished steps.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from statistics import median

from pipelines.engine.cache import Cache
from pipelines.engine.entry_manifest import Entry
from pipelines.engine.step import Step, seconds_to_the_end, stored_contents, whole

_LOOKED_AT = 3  # newest stored results of a kind
_PRIOR = 10.0  # s: finished steps that took much less hardly change the scale
_FASTEST = 0.67  # a smaller ratio means that the estimates were too long, not that the machine is that fast
_SLOWEST = 3.0  # a larger ratio means that a step waited, or that its estimate was too short
_OVERDUE = 0.2  # expected remaining time of a step that exceeds its expected time, over the time it has taken


@dataclass(frozen=True, kw_only=True)
class Task:
    """A computation, the tasks for which it waits, and its expected time in seconds."""

    name: str
    takes: tuple[str, ...]
    seconds: float
    kind: str = ""
    compiles: bool = False  # without events: it begins when its inputs are finished, and ends with the steps that wait


class Remaining:
    """The tasks of a run that are not finished.

    Parameters
    ----------
    tasks : each after those for which it waits
    processes : number of tasks that run at the same time
    """

    def __init__(self, tasks: Iterable[Task], processes: int) -> None:
        self._left = {task.name: task for task in tasks}
        self._processes = processes
        self._since: dict[str, float] = {}  # start of each running task, s
        self._shares: dict[str, list[tuple[float, float]]] = {}  # first and last reported share with their times
        self._expected = self._took = _PRIOR
        self._factors: dict[str, float] = {}  # by kind: actual over expected time of the last finished step

    @property
    def count(self) -> int:
        """Number of steps that are not finished."""
        return sum(not task.compiles for task in self._left.values())

    def started(self, name: str, now: float) -> None:
        """Note that a task runs since `now`, s."""
        self._since[name] = now
        self._begin_compiling(now)

    def advanced(self, name: str, share: float, now: float) -> None:
        """Note that a share (0 to 1) of a task is done. Before its first share, the task reads and compiles."""
        first = self._shares.get(name, [(share, now)])[0]
        self._shares[name] = [first, (share, now)]
        for compiling in self._compiling_of(name):
            del self._left[compiling.name]

    def finished(self, name: str, now: float) -> None:
        """Note that a task is finished, or that a stored result is used."""
        if name in self._left and name in self._since:
            (first, since), (last, then) = self._shares.get(name, [(0.0, self._since[name]), (1.0, now)])
            task, code = self._left[name], sum(compiling.seconds for compiling in self._compiling_of(name))
            share = task.seconds * (last - first)
            self._expected += share + code
            self._took += min(then - since, _SLOWEST * (share + code))
            if share and not code:
                self._factors[task.kind] = (then - since) / share
        for compiling in self._compiling_of(name):
            del self._left[compiling.name]
        self._left.pop(name, None)
        self._begin_compiling(now)

    def left(self, now: float) -> float:
        """Seconds to the end. Tasks begin when their inputs are finished, those with the longest chain first."""
        waiting = dict(self._left)
        at_work = {name: self._left_of(waiting.pop(name), now) for name in self._left if name in self._since}
        chain = seconds_to_the_end((task.name, task.seconds, task.takes) for task in self._left.values())
        time = 0.0
        while at_work or waiting:
            ready = [task for task in waiting.values() if not any(n in at_work or n in waiting for n in task.takes)]
            ready.sort(key=lambda task: -chain[task.name])
            for task in ready[: max(self._processes - len(at_work), 0)]:
                at_work[task.name] = self._scaled(waiting.pop(task.name))
            soonest = min(at_work.values())
            time += soonest
            at_work = {name: seconds - soonest for name, seconds in at_work.items() if seconds > soonest}
        return time

    def pace(self, name: str) -> float | None:
        """Remaining seconds of a task at its pace since the first share; None before the second share."""
        (first, since), (last, then) = self._shares.get(name, [(0.0, 0.0), (0.0, 0.0)])
        return (then - since) * (1.0 - last) / (last - first) if last > first else None

    def _left_of(self, task: Task, now: float) -> float:
        """Remaining seconds of a running task."""
        pace = self.pace(task.name)
        if pace is not None:
            return max(pace - (now - self._shares[task.name][1][1]), 0.0)
        compiling = [self._left_of(one, now) for one in self._compiling_of(task.name)]
        if compiling:
            return sum(compiling) + self._scaled(task)
        took = now - self._since.get(task.name, now)
        return max(self._scaled(task) - took, _OVERDUE * took)

    def _scaled(self, task: Task) -> float:
        """Seconds of a complete task on this machine."""
        machine = max(self._took / self._expected, _FASTEST)
        return task.seconds * self._factors.get(task.kind, machine)

    def _compiling_of(self, name: str) -> list[Task]:
        takes = self._left[name].takes if name in self._left else ()
        return [self._left[one] for one in takes if one in self._left and self._left[one].compiles]

    def _begin_compiling(self, now: float) -> None:
        for task in self._left.values():
            if task.compiles and not any(name in self._left for name in task.takes):
                self._since.setdefault(task.name, now)


def expected(steps: Iterable[Step], cache: Cache) -> list[Task]:
    """The tasks of the steps that are not in the cache, as far as this is known before any step is built."""
    steps = list(steps)
    contents, _ = stored_contents(steps, cache, {}, _like)
    missing = [step for step in steps if step.name not in contents]
    factors: dict[str, float | None] = {}
    for kind in dict.fromkeys(step.kind for step in missing):
        facts = [entry.facts for entry in _newest(cache, kind)]
        ratios = [one["seconds"] / one["estimate"] for one in facts if one.get("estimate")]
        factors[kind] = median(ratios) if ratios else None
    known = [factor for factor in factors.values() if factor is not None]
    machine = median(known) if known else 1.0
    compiled = [path.name for path in cache.compiled()]
    tasks: dict[str, Task] = {}
    for step in missing:
        seconds = sum(s for start, s in step.compiles.items() if not any(name.startswith(start) for name in compiled))
        takes, compiling = step.inputs, f"code of {step.kind}"
        if seconds:
            code = Task(
                name=compiling, kind=compiling, takes=step.prepare_takes, seconds=machine * seconds, compiles=True
            )
            tasks.setdefault(compiling, code)
            takes = (*takes, compiling)
        seconds = step.seconds * (factors[step.kind] or machine)
        tasks[step.name] = Task(name=step.name, takes=takes, seconds=seconds, kind=step.kind)
    return list(tasks.values())


def _like(step: Step, cache: Cache, contents: Mapping[str, str]) -> Entry | None:
    """For a step without a spec: a stored result that was built from the same inputs."""
    if step.spec is not None:
        return None
    took = step.received(contents.__getitem__)
    return next((entry for entry in _newest(cache, step.kind) if entry.facts["takes"] == took), None)


def _newest(cache: Cache, kind: str) -> Iterator[Entry]:
    return islice(filter(whole, cache.entries(kind)), _LOOKED_AT)
