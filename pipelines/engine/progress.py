"""What a long command shows while it works: steps and time left, as a bar at a terminal, else as plain lines."""

from __future__ import annotations

import contextlib
import logging
import re
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from pipelines.engine.build_step import Result
from pipelines.engine.cache import Cache
from pipelines.engine.remaining import Remaining, expected
from pipelines.engine.run_graph import LONG_SECONDS, Observer
from pipelines.engine.step import Step
from pipelines.io.shown import duration

if TYPE_CHECKING:
    from rich.progress import Progress

_LOG = logging.getLogger("pipelines.engine.step")
_MOTION = re.compile(  # names of the steps of a study, as `pipelines.steps.study` composes them
    r"(?P<features>features )?(?P<torque>torque )?(healthy seed (?P<seeded>\d+) )?(seed (?P<seed>\d+) )?"
    r"(?P<free>error-free )?(?P<healthy>healthy )?simulate"
)
_LINE_SECONDS = 10.0  # between two lines about a step at work


@dataclass(frozen=True, kw_only=True)
class StepProgress:
    """What a progress function is told: a step of the work was started, built (in `seconds`) or reused."""

    name: str
    state: Literal["started", "built", "reused"]
    seconds: float = 0.0


ProgressFunction = Callable[[StepProgress], None]


class Telling:
    """Tells a function."""

    def __init__(self, told: ProgressFunction) -> None:
        self._told = told

    def started(self, step: Step) -> None:
        """A step is at work."""
        self._told(StepProgress(name=step.name, state="started"))

    def advanced(self, step: Step, share: float) -> None:
        """Nothing: a function is told of whole steps."""

    def finished(self, step: Step, result: Result) -> None:
        """A step is done."""
        state: Literal["built", "reused"] = "reused" if result.record.reused else "built"
        self._told(StepProgress(name=step.name, state=state, seconds=result.record.seconds))


class Logging:
    """Logs what happens, with the facts that the structured log keeps."""

    def started(self, step: Step) -> None:
        """Logged at INFO."""
        _LOG.info("%s: started", step.name)

    def advanced(self, step: Step, share: float) -> None:
        """Nothing."""

    def finished(self, step: Step, result: Result) -> None:
        """Logged at INFO."""
        record = result.record
        verb = "reused" if record.reused else f"built in {record.seconds:.2f} s, {record.peak_bytes / 1e6:.0f} MB"
        facts = {"step": record.name, "key": record.key[:32], "reused": record.reused, "seconds": record.seconds}
        _LOG.info("%s: %s", step.name, verb, extra={"facts": facts})


class Timing:
    """Keeps the account of what remains."""

    def __init__(self, remaining: Remaining, clock: Callable[[], float]) -> None:
        self._remaining, self._clock = remaining, clock

    def started(self, step: Step) -> None:
        """Pass on, with the time."""
        self._remaining.started(step.name, self._clock())

    def advanced(self, step: Step, share: float) -> None:
        """Pass on, with the time."""
        self._remaining.advanced(step.name, share, self._clock())

    def finished(self, step: Step, result: Result) -> None:
        """Pass on, with the time."""
        self._remaining.finished(step.name, self._clock())


def step_words(name: str) -> str:
    """The name of a step in words: "features healthy simulate" is "features of the healthy machine"."""
    case, colon, name = name.rpartition(": ")  # of a study: "preset: reference: simulate"
    if case:
        return f"{case}{colon}{step_words(name)}"
    found = _MOTION.fullmatch(name)
    if found is None:
        return name
    what = "features" if found["features"] else "motion"
    machine = "healthy machine" if found["healthy"] or found["seeded"] else "machine"
    parts = ["load as a torque"] if found["torque"] else []
    if seed := found["seed"] or found["seeded"]:
        parts.append(f"deviations of seed {seed}")
    parts += ["no deviations"] if found["free"] else []
    return f"{what} of the {machine}" + (f" ({', '.join(parts)})" if parts else "")


class Lines:
    """Lines for a pipe or a file: what is computed, for how long it has been, and how long the rest takes."""

    def __init__(self, remaining: Remaining, write: Callable[[str], Any], clock: Callable[[], float]) -> None:
        self._remaining, self._write, self._clock = remaining, write, clock
        self._start = self._said = clock()
        if remaining.count:
            count = f"{remaining.count} step" + ("s" if remaining.count > 1 else "")
            write(f"{count} to compute, about {duration(remaining.left(self._start))}\n")

    def started(self, step: Step) -> None:
        """Name a step that takes long."""
        if step.seconds >= LONG_SECONDS:
            self._say(f"{step_words(step.name)}: started")

    def advanced(self, step: Step, share: float) -> None:
        """How far a step is, now and then."""
        if self._clock() - self._said >= _LINE_SECONDS:
            self._say(f"{step_words(step.name)}: {100 * share:.0f} %")

    def finished(self, step: Step, result: Result) -> None:
        """What was built, and in which time."""
        if not result.record.reused:
            self._say(f"{step_words(step.name)}: {result.record.seconds:.1f} s")

    def _say(self, what: str) -> None:
        self._said = self._clock()
        left = f"; about {duration(self._remaining.left(self._said))} left" if self._remaining.count else ""
        self._write(f"{self._said - self._start:4.0f} s  {what}{left}\n")


class Bar:
    """A progress display: steps done, and the names of those at work; with the time left if they tell their share."""

    def __init__(self, progress: Progress, remaining: Remaining) -> None:
        self._progress, self._remaining, self._total = progress, remaining, remaining.count
        self._task = progress.add_task("steps", total=self._total)
        self._working: dict[str, str] = {}

    def started(self, step: Step) -> None:
        """Show the name."""
        self._working[step.name] = step_words(step.name)
        self._show()

    def advanced(self, step: Step, share: float) -> None:
        """Show the share and the time left."""
        left = self._remaining.pace(step.name)
        text = f"{step_words(step.name)} {100 * share:.0f} %"
        self._working[step.name] = text if left is None else f"{text}, {left:.0f} s left"
        self._show()

    def finished(self, step: Step, result: Result) -> None:
        """Count, and print a line for what was built."""
        self._working.pop(step.name, None)
        if not result.record.reused:
            text = f"{step_words(step.name)}: {result.record.seconds:.1f} s"
            self._progress.console.print(text, highlight=False, markup=False)
        self._progress.update(self._task, completed=self._total - self._remaining.count)
        self._show()

    def _show(self) -> None:
        self._progress.update(self._task, description=", ".join(self._working.values()) or "steps")


class Several:
    """Tells several observers."""

    def __init__(self, *observers: Observer) -> None:
        self._observers = observers

    def started(self, step: Step) -> None:
        """Pass on."""
        for observer in self._observers:
            observer.started(step)

    def advanced(self, step: Step, share: float) -> None:
        """Pass on."""
        for observer in self._observers:
            observer.advanced(step, share)

    def finished(self, step: Step, result: Result) -> None:
        """Pass on."""
        for observer in self._observers:
            observer.finished(step, result)


@contextlib.contextmanager
def shown_progress(
    steps: Iterable[Step], cache: Cache, processes: int, *, quiet: bool, told: ProgressFunction | None = None
) -> Iterator[Observer]:
    """An observer that logs, tells a function, and shows progress on standard error if `quiet` is off.

    A terminal gets a bar, anything else plain lines.

    Parameters
    ----------
    steps : of the run, each one after those it takes
    cache : where results are stored
    processes : long steps built at the same time
    quiet : show nothing
    told : a function that is told of every step
    """
    import sys

    listeners: list[Observer] = [Logging()] if told is None else [Logging(), Telling(told)]
    if quiet:
        yield Several(*listeners)
        return
    remaining = Remaining(expected(steps, cache), processes)
    timing = Timing(remaining, time.monotonic)
    if not sys.stderr.isatty():
        yield Several(timing, Lines(remaining, sys.stderr.write, time.monotonic), *listeners)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, SpinnerColumn, TextColumn
    from rich.progress import Task as Shown
    from rich.text import Text

    class Left(ProgressColumn):
        """The time left."""

        def render(self, task: Shown) -> Text:
            return Text(f"{duration(remaining.left(time.monotonic()))} left" if remaining.count else "")

    columns = (
        SpinnerColumn(),
        BarColumn(),
        MofNCompleteColumn(),
        Left(),
        TextColumn("{task.description}", markup=False),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        yield Several(timing, Bar(progress, remaining), *listeners)
