"""What this process does in threads, while steps are built in processes of their own. Results do not depend on it.

A step can compile its code before its turn, which takes longer than most steps where nothing is compiled yet. Short
steps that no long one waits for are built: pictures, features.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Mapping

from pipelines.engine.build_step import Result, build_here
from pipelines.engine.cache import Cache
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
        _log.debug("step %s, preparation failed: %s", step.name, error)


class Aside:
    """Builds one step at a time; a thread that is not finished ends with the process."""

    def __init__(self) -> None:
        self._step: Step | None = None
        self._thread: threading.Thread | None = None
        self._result: Result | Exception | None = None

    def start(self, step: Step, key: str, upstream: Mapping[str, Result], cache: Cache) -> None:
        """Begin to build a step; `free` must be true.

        Parameters
        ----------
        step, key : the step, and the key of its result
        upstream : results by the names of the steps that it takes
        cache : where the result is stored
        """
        assert self._step is None, "one step at a time"

        def run() -> None:
            try:
                self._result = build_here(step, key, upstream, cache)
            except Exception as error:
                self._result = error

        self._step, self._result = step, None
        self._thread = threading.Thread(target=run, daemon=True)
        self._thread.start()

    @property
    def free(self) -> bool:
        """Whether no step is being built, nor built and not yet taken."""
        return self._step is None

    @property
    def ready(self) -> bool:
        """Whether a step is built, or failed."""
        return self._step is not None and self._result is not None

    def names(self) -> set[str]:
        """The name of the step that is being built, if there is one."""
        return {self._step.name} if self._step else set()

    def take(self) -> tuple[Step, Result | Exception]:
        """The step, when it is ready, and its result or what it raised."""
        assert self._step is not None
        assert self._thread is not None
        self._thread.join()
        assert self._result is not None
        step, self._step = self._step, None
        return step, self._result
