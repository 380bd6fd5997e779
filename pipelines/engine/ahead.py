"""What a step can do before its turn: in a thread, while other steps are built in processes of their own.

It compiles code, which takes longer than most steps where nothing is compiled yet. Results do not depend on it.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Mapping

from pipelines.engine.build_step import Result
from pipelines.engine.step import Graph, Step

_log = logging.getLogger(__name__)


class Ahead:
    """Starts every step's own work once."""

    def __init__(self) -> None:
        self._threads: dict[str, threading.Thread] = {}

    def start(self, graph: Graph, results: Mapping[str, Result]) -> None:
        """Begin what needs nothing but these results."""
        for step in graph:
            if step.ahead is None or step.name in results or step.name in self._threads:
                continue
            if all(name in results for name in step.ahead_takes):
                taken = [results[name] for name in step.ahead_takes]
                thread = threading.Thread(target=_run, args=(step, taken), daemon=True)
                self._threads[step.name] = thread
                thread.start()

    def finish(self, step: Step) -> None:
        """Wait for what this step has begun."""
        if step.name in self._threads:
            self._threads[step.name].join()


def _run(step: Step, taken: list[Result]) -> None:
    assert step.ahead is not None
    try:
        step.ahead(step.spec, *(result.load() for result in taken))
    except Exception as error:  # the build itself says what is wrong
        _log.debug("step %s, ahead of its build: %s", step.name, error)
