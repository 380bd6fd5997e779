"""How work is done and who is told of it: the one way in which commands and Python build steps."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field

from pipelines.engine.cache import Cache
from pipelines.engine.progress import ProgressFunction, shown_progress
from pipelines.engine.run_graph import Observer, Outcome, run_graph, side_by_side
from pipelines.engine.step import Graph, Step


@dataclass(frozen=True, kw_only=True)
class Work:
    """`processes` long steps are built side by side (None: 2, or 1 on a single core); `progress` is told of each."""

    processes: int | None = None
    quiet: bool = True
    progress: ProgressFunction | None = None
    cache: Cache = field(default_factory=Cache)

    def observed(self, steps: Iterable[Step] = ()) -> AbstractContextManager[Observer]:
        """An observer of a run of these steps, in an order in which each one comes after those it takes."""
        processes = side_by_side(self.processes)
        return shown_progress(steps, self.cache, processes, quiet=self.quiet, told=self.progress)

    def build(self, graph: Graph, wanted: Iterable[str]) -> Outcome:
        """The wanted steps and what they take, from the cache or built."""
        wanted = tuple(wanted)
        with self.observed(graph.needed(wanted)) as observer:
            return run_graph(graph, self.cache, wanted, observer=observer, processes=self.processes)
