"""Progress of long work: to the log, to a function, and on standard error: a bar at a terminal, else plain lines."""

from __future__ import annotations

import contextlib
import logging
import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from pipelines.engine.build_step import Event, StepRecord
from pipelines.engine.cache import Cache
from pipelines.engine.remaining import Remaining, expected
from pipelines.engine.step import LONG_SECONDS, Step
from pipelines.io.shown_text import duration

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

_LOG = logging.getLogger("pipelines.engine.step")
_MOTION = re.compile(  # names of the steps of a run, as `pipelines.steps.run_plan` composes them
    r"(?P<features>features )?(?P<torque>torque )?(healthy seed (?P<seeded>\d+) )?(seed (?P<seed>\d+) )?"
    r"(?P<free>error-free )?(?P<healthy>healthy )?simulate"
)
_LAW = re.compile(r"(?P<unmodified>unmodified_)?law_(?P<stage>\d+)")
_LINE_SECONDS = 10.0  # between two lines about a step at work
_COUNT_SECONDS = 30.0  # between two lines about a count

Write = Callable[[str], Any]


@dataclass(frozen=True, kw_only=True)
class StepProgress:
    """What a progress function is called with: a step of the work was started, built (in `seconds`) or reused."""

    name: str
    state: Literal["started", "built", "reused"]
    seconds: float = 0.0


ProgressFunction = Callable[[StepProgress], None]


class StepReporter:
    """Reports every event of a run.

    Parameters
    ----------
    remaining : the tasks that are not finished
    on_progress : called when a step starts or is done
    write : takes lines about steps that are long or built
    bar : shows the steps at work, with their share and the time left
    clock : s
    """

    def __init__(
        self,
        remaining: Remaining,
        *,
        on_progress: ProgressFunction | None = None,
        write: Write | None = None,
        bar: Progress | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._remaining, self._on_progress, self._write, self._clock = remaining, on_progress, write, clock
        self._start = self._reported = clock()
        self._bar, self._total = bar, remaining.count
        self._task = None if bar is None else bar.add_task("steps", total=self._total)
        self._working: dict[str, str] = {}
        if write and self._total:
            count = f"{self._total} step" + ("s" if self._total > 1 else "")
            write(f"{count} to compute, about {duration(remaining.left(self._start))}\n")

    def __call__(self, event: Event) -> None:
        """Report one event."""
        name, words, now = event.step.name, step_words(event.step.name), self._clock()
        if event.share is not None:
            self._remaining.advanced(name, event.share, now)
            pace = self._remaining.pace(name)
            text = f"{words} {100 * event.share:.0f} %"
            self._working[name] = text if pace is None else f"{text}, {pace:.0f} s left"
            line = f"{words}: {100 * event.share:.0f} %" if now - self._reported >= _LINE_SECONDS else ""
        elif event.result is None:
            self._note(name, None)
            self._remaining.started(name, now)
            self._working[name] = words
            line = f"{words}: started" if event.step.seconds >= LONG_SECONDS else ""
        else:
            record = event.result.record
            self._note(name, record)
            self._remaining.finished(name, now)
            self._working.pop(name, None)
            line = "" if record.reused else f"{words}: {record.seconds:.1f} s"
        if self._bar is not None and self._task is not None:
            if line and event.result is not None:
                self._bar.console.print(line, highlight=False, markup=False)
            done, working = self._total - self._remaining.count, ", ".join(self._working.values())
            self._bar.update(self._task, completed=done, description=working or "steps")
        elif self._write is not None and line:
            self._reported = now
            left = f"; about {duration(self._remaining.left(now))} left" if self._remaining.count else ""
            self._write(f"{now - self._start:4.0f} s  {line}{left}\n")

    def _note(self, name: str, record: StepRecord | None) -> None:
        """Log a step that starts (no record) or is done, and call the progress function."""
        state: Literal["started", "built", "reused"] = "started"
        if record is None:
            _LOG.info("%s: started", name)
        else:
            state = "reused" if record.reused else "built"
            cost = "" if record.reused else f" in {record.seconds:.2f} s, {record.peak_bytes / 1e6:.0f} MB"
            facts = {"step": record.name, "key": record.key[:32], "reused": record.reused, "seconds": record.seconds}
            _LOG.info("%s: %s%s", name, state, cost, extra={"facts": facts})
        if self._on_progress is not None:
            self._on_progress(StepProgress(name=name, state=state, seconds=record.seconds if record else 0.0))


class CountReporter:
    """Reports how many of many like things (`unit`, in the plural) are done: ``reporter(done, total, failed)``."""

    def __init__(self, unit: str) -> None:
        self._unit = unit
        self._write: Write | None = None
        self._bar: Progress | None = None
        self._task: TaskID | None = None
        self._start = self._reported = time.monotonic()
        self._done = self._total = 0

    def show_on(self, write: Write | None, bar: Progress | None) -> None:
        """Write a line twice a minute, or show the count on a bar."""
        self._write, self._bar = write, bar
        self._task = None if bar is None else bar.add_task(self._unit, total=None)

    def __call__(self, done: int, total: int, failed: int = 0) -> None:
        """So many are done."""
        self._done, self._total = done, total
        failures = f", {failed} failed" if failed else ""
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, completed=done, total=total, description=f"{self._unit}{failures}")
        elif time.monotonic() - self._reported >= _COUNT_SECONDS:
            self.line(f"{done} of {total} {self._unit}{failures}, about {self.left()}")

    def left(self) -> str:
        """The time left in words, "" before anything is done."""
        each = (time.monotonic() - self._start) / self._done if self._done else 0.0
        return f"{duration((self._total - self._done) * each)} left" if self._done else ""

    def line(self, text: str) -> None:
        """Show a line of text."""
        self._reported = time.monotonic()
        if self._bar is not None:
            self._bar.console.print(text, highlight=False, markup=False)
        elif self._write is not None:
            self._write(f"{text}\n")


def step_words(name: str) -> str:
    """The name of a step in words: "features healthy simulate" is "features of the healthy machine"."""
    case, colon, name = name.rpartition(": ")  # of a study: "preset: reference: simulate"
    if case:
        return f"{case}{colon}{step_words(name)}"
    if found := _LAW.fullmatch(name):
        return f"mesh law of stage {found['stage']}" + (
            " without faults and modifications" if found["unmodified"] else ""
        )
    found = _MOTION.fullmatch(name)
    if found is None:
        return "diagnosis" if name == "diagnose" else name
    what = "features" if found["features"] else "motion"
    machine = "healthy machine" if found["healthy"] or found["seeded"] else "machine"
    parts = ["load as a torque"] if found["torque"] else []
    if seed := found["seed"] or found["seeded"]:
        parts.append(f"deviations of seed {seed}")
    parts += ["no deviations"] if found["free"] else []
    return f"{what} of the {machine}" + (f" ({', '.join(parts)})" if parts else "")


@contextlib.contextmanager
def reported_steps(
    steps: Iterable[Step], cache: Cache, processes: int, *, quiet: bool, on_progress: ProgressFunction | None = None
) -> Iterator[StepReporter]:
    """The reporter of a run.

    Parameters
    ----------
    steps : of the run, each one after those it takes
    cache : where results are stored
    processes : long steps built at the same time
    quiet : show nothing on standard error
    on_progress : as in `StepReporter`
    """
    remaining = Remaining(() if quiet else expected(steps, cache), processes)

    def left() -> str:
        return f"{duration(remaining.left(time.monotonic()))} left" if remaining.count else ""

    with _standard_error(left, quiet=quiet) as (write, bar):
        yield StepReporter(remaining, on_progress=on_progress, write=write, bar=bar)


@contextlib.contextmanager
def reported_count(unit: str, *, quiet: bool) -> Iterator[CountReporter]:
    """The reporter of a count of things (their name in the plural); it shows nothing if `quiet`."""
    reporter = CountReporter(unit)
    with _standard_error(reporter.left, quiet=quiet) as (write, bar):
        reporter.show_on(write, bar)
        yield reporter


@contextlib.contextmanager
def _standard_error(left: Callable[[], str], *, quiet: bool) -> Iterator[tuple[Write | None, Progress | None]]:
    """A function that writes lines, or (at a terminal) a bar that shows what `left` returns; neither if `quiet`."""
    if quiet or not sys.stderr.isatty():
        yield None if quiet else sys.stderr.write, None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        ProgressColumn,
        SpinnerColumn,
        TextColumn,
        TimeElapsedColumn,
    )
    from rich.progress import Task as Shown
    from rich.text import Text

    class Left(ProgressColumn):
        """The time left."""

        def render(self, task: Shown) -> Text:
            return Text(left())

    columns = (SpinnerColumn(), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), Left())
    described = TextColumn("{task.description}", markup=False)
    with Progress(*columns, described, console=Console(stderr=True), transient=True) as progress:
        yield None, progress
