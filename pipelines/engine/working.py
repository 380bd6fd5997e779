"""How work is done and to whom it is reported: the one way in which commands and Python build steps."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from pipelines.engine.build_step import Event, Result
from pipelines.engine.cache import Cache
from pipelines.engine.progress import ProgressFunction, reported_steps
from pipelines.engine.run_graph import Outcome, run_graph, side_by_side
from pipelines.engine.step import Graph, Step


@dataclass(frozen=True, kw_only=True)
class Work:
    """`processes` long steps are built side by side (None: 2, or 1 on a single core); `progress` is called for each."""

    processes: int | None = None
    quiet: bool = True
    progress: ProgressFunction | None = None
    cache: Cache = field(default_factory=Cache)

    def build(
        self, graph: Graph, wanted: Iterable[str], on_result: Callable[[Step, Result], None] = lambda step, result: None
    ) -> Outcome:
        """The wanted steps and what they take, from the cache or built; `on_result` is called with each of them."""
        wanted = tuple(wanted)
        processes = side_by_side(self.processes)
        steps = graph.needed(wanted)
        with reported_steps(steps, self.cache, processes, quiet=self.quiet, on_progress=self.progress) as report:

            def on_event(event: Event) -> None:
                report(event)
                if event.result is not None:
                    on_result(event.step, event.result)

            return run_graph(graph, self.cache, wanted, on_event=on_event, processes=processes)
