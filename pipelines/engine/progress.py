"""What a long command shows while it works: a line per step, and the one at work; nothing if not at a terminal."""

from __future__ import annotations

import contextlib
import logging
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from pipelines.engine.run_graph import Observer
from pipelines.engine.step import Step, StepRecord

if TYPE_CHECKING:
    from rich.progress import Progress

_LOG = logging.getLogger("pipelines.engine.step")


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

    def finished(self, step: Step, record: StepRecord) -> None:
        """A step is done."""
        state: Literal["built", "reused"] = "reused" if record.reused else "built"
        self._told(StepProgress(name=step.name, state=state, seconds=record.seconds))


class Logging:
    """Logs what happens, with the facts that the structured log keeps."""

    def started(self, step: Step) -> None:
        """Logged at INFO."""
        _LOG.info("%s: started", step.name)

    def advanced(self, step: Step, share: float) -> None:
        """Nothing."""

    def finished(self, step: Step, record: StepRecord) -> None:
        """Logged at INFO."""
        verb = "reused" if record.reused else f"built in {record.seconds:.2f} s, {record.peak_bytes / 1e6:.0f} MB"
        facts = {"step": record.name, "key": record.key[:32], "reused": record.reused, "seconds": record.seconds}
        _LOG.info("%s: %s", step.name, verb, extra={"facts": facts})


class Pace:
    """The time that a step still takes, from the shares that it tells.

    The pace counts from the first share on: what comes before, reading and compiling, is not repeated.
    """

    def __init__(self) -> None:
        self._first: tuple[float, float] | None = None

    def left(self, share: float, now: float) -> float | None:
        """Seconds; None while they cannot be known.

        Parameters
        ----------
        share : done, 0 to 1
        now : s
        """
        if self._first is None:
            self._first = (share, now)
        done = share - self._first[0]
        return (now - self._first[1]) * (1.0 - share) / done if done > 0.0 else None


class Bar:
    """A progress display: steps done, and the names of those at work; with the time left if they tell their share."""

    def __init__(self, progress: Progress, total: int) -> None:
        self._progress = progress
        self._task = progress.add_task("steps", total=total)
        self._working: dict[str, str] = {}
        self._pace: dict[str, Pace] = {}

    def started(self, step: Step) -> None:
        """Show the name."""
        self._working[step.name] = step.name
        self._show()

    def advanced(self, step: Step, share: float) -> None:
        """Show the share and the time left."""
        left = self._pace.setdefault(step.name, Pace()).left(share, time.monotonic())
        self._working[step.name] = f"{step.name} {100 * share:.0f} %" + ("" if left is None else f", {left:.0f} s left")
        self._show()

    def finished(self, step: Step, record: StepRecord) -> None:
        """Count, and print a line for what was built."""
        self._working.pop(step.name, None)
        self._pace.pop(step.name, None)
        if not record.reused:
            self._progress.console.print(f"{record.name}: {record.seconds:.1f} s", highlight=False, markup=False)
        self._progress.advance(self._task)
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

    def finished(self, step: Step, record: StepRecord) -> None:
        """Pass on."""
        for observer in self._observers:
            observer.finished(step, record)


@contextlib.contextmanager
def shown_progress(total: int, *, quiet: bool, told: ProgressFunction | None = None) -> Iterator[Observer]:
    """An observer that logs, tells a function, and shows progress on standard error if that is a terminal and `quiet`
    is off."""
    import sys

    listeners: list[Observer] = [Logging()] if told is None else [Logging(), Telling(told)]
    if quiet or not sys.stderr.isatty():
        yield Several(*listeners)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (
        SpinnerColumn(),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.description}", markup=False),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        yield Several(Bar(progress, total), *listeners)
