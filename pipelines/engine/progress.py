"""What a long command shows while it works: a line per stage, and the one at work; nothing if not at a terminal."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator
from typing import TYPE_CHECKING

from pipelines.engine.run_graph import Observer, Silent
from pipelines.engine.step import Stage, StageRecord

if TYPE_CHECKING:
    from rich.progress import Progress

_LOG = logging.getLogger("pipelines.engine.step")


class Logging:
    """Logs what happens, with the facts that the structured log keeps."""

    def started(self, stage: Stage) -> None:
        """Logged at INFO."""
        _LOG.info("%s: started", stage.name)

    def finished(self, stage: Stage, record: StageRecord) -> None:
        """Logged at INFO."""
        verb = "reused" if record.reused else f"built in {record.seconds:.2f} s, {record.peak_bytes / 1e6:.0f} MB"
        facts = {"stage": record.name, "key": record.key[:32], "reused": record.reused, "seconds": record.seconds}
        _LOG.info("%s: %s", stage.name, verb, extra={"facts": facts})


class Bar:
    """A progress display: stages done, and the names of those at work."""

    def __init__(self, progress: Progress, total: int) -> None:
        self._progress = progress
        self._task = progress.add_task("stages", total=total)
        self._working: dict[str, None] = {}

    def started(self, stage: Stage) -> None:
        """Show the name."""
        self._working[stage.name] = None
        self._show()

    def finished(self, stage: Stage, record: StageRecord) -> None:
        """Count, and print a line for what was built."""
        self._working.pop(stage.name, None)
        if not record.reused:
            self._progress.console.print(f"{record.name}: {record.seconds:.1f} s", highlight=False, markup=False)
        self._progress.advance(self._task)
        self._show()

    def _show(self) -> None:
        self._progress.update(self._task, description=", ".join(self._working) or "stages")


class Several:
    """Tells several observers."""

    def __init__(self, *observers: Observer) -> None:
        self._observers = observers

    def started(self, stage: Stage) -> None:
        """Pass on."""
        for observer in self._observers:
            observer.started(stage)

    def finished(self, stage: Stage, record: StageRecord) -> None:
        """Pass on."""
        for observer in self._observers:
            observer.finished(stage, record)


@contextlib.contextmanager
def shown_progress(total: int, *, quiet: bool) -> Iterator[Observer]:
    """An observer that logs, and shows progress on standard error if that is a terminal and `quiet` is off."""
    import sys

    if quiet or not sys.stderr.isatty():
        yield Several(Silent(), Logging())
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
        yield Several(Bar(progress, total), Logging())
