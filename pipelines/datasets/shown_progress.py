"""What a campaign shows while it runs: a bar with the time left at a terminal, a line a minute in a log."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from pipelines.datasets.job import Done
from pipelines.datasets.rows import FAILED
from pipelines.datasets.workers import Workers
from pipelines.io.shown import duration

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

_LINE_SECONDS = 60.0


class Silent:
    """Shows nothing."""

    def begun(self, total: int, left: int, workers: Workers) -> None:
        """Nothing."""

    def told(self, done: Done) -> None:
        """Nothing."""


class Lines(Silent):
    """A line when it begins, one a minute, on standard error."""

    def __init__(self) -> None:
        self._left = self._done = self._failed = 0
        self._start = self._said = time.monotonic()

    def begun(self, total: int, left: int, workers: Workers) -> None:
        """How much there is to do."""
        self._left, self._start = left, time.monotonic()
        self._say(beginning(total, left, workers))

    def told(self, done: Done) -> None:
        """Count it; say how far it is if a minute has gone."""
        self._done += 1
        self._failed += done.row["status"] == FAILED
        if time.monotonic() - self._said >= _LINE_SECONDS:
            each = (time.monotonic() - self._start) / self._done
            left = duration((self._left - self._done) * each)
            self._say(f"{self._done} of {self._left} scenes, {self._failed} failed, about {left} left")

    def _say(self, line: str) -> None:
        self._said = time.monotonic()
        sys.stderr.write(f"{line}\n")
        sys.stderr.flush()


class Bar(Silent):
    """A progress bar with the time left."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._task: TaskID | None = None
        self._failed = 0

    def begun(self, total: int, left: int, workers: Workers) -> None:
        """Show how much there is to do."""
        self._progress.console.print(beginning(total, left, workers), highlight=False, markup=False)
        self._task = self._progress.add_task("scenes", total=left)

    def told(self, done: Done) -> None:
        """Count it, and say why one failed."""
        assert self._task is not None
        if done.row["status"] == FAILED:
            self._failed += 1
            line = f"scene {done.run} failed: {done.row['reason']}"
            self._progress.console.print(line, highlight=False, markup=False)
        label = f"scenes, {self._failed} failed" if self._failed else "scenes"
        self._progress.update(self._task, advance=1, description=label)


def beginning(total: int, left: int, workers: Workers) -> str:
    """The first line of a campaign."""
    done = f", {total - left} already done" if left < total else ""
    board = f"; {workers.dashboard}" if workers.dashboard else ""
    return f"{total} scenes{done}; {workers.count()} workers{board}"


def lines_now_and_then(*, quiet: bool) -> Callable[[int, int], None]:
    """Says on standard error, twice a minute, how many runs of how many are done; nothing if `quiet`."""
    said = time.monotonic()

    def told(done: int, total: int) -> None:
        nonlocal said
        if not quiet and time.monotonic() - said >= _LINE_SECONDS / 2:
            said = time.monotonic()
            sys.stderr.write(f"{done} of {total} runs\n")

    return told


@contextlib.contextmanager
def shown_campaign(*, quiet: bool) -> Iterator[Silent]:
    """What is told of a campaign: nothing if `quiet`, a bar at a terminal, else lines."""
    if quiet:
        yield Silent()
    elif not sys.stderr.isatty():
        yield Lines()
    else:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}", markup=False))
        with Progress(
            *columns, TimeElapsedColumn(), TimeRemainingColumn(), console=Console(stderr=True), transient=True
        ) as progress:
            yield Bar(progress)
