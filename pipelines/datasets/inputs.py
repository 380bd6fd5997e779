"""What motions are made of, laws and casings: built once by whoever needs it first, shared through the cache.

Each missing result is built by one process alone. A process that finds one taken goes on with another one of its
scene, and waits only when nothing else is left to build.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

from pipelines.engine.build_step import Result
from pipelines.engine.cache import Cache
from pipelines.engine.run_graph import Outcome, run_graph
from pipelines.engine.step import Graph, Step, stored

_WAIT_SECONDS = 0.1


def build_inputs(graph: Graph, wanted: Sequence[str], cache: Cache) -> Outcome:
    """The wanted steps and what they take, each distinct one built by one process alone.

    Parameters
    ----------
    graph, wanted, cache : as `pipelines.engine.run_graph.run_graph`

    Raises
    ------
    whatever a step raises
    """
    graph = graph.needed(wanted)
    known: Mapping[str, Result] = {}
    while missing := _missing(graph, cache, known):
        for step, key in missing:
            with cache.alone(key) as mine:
                if mine:
                    known = {**known, **run_graph(graph, cache, [step.name], known=known, processes=1).results}
                    break
        else:
            time.sleep(_WAIT_SECONDS)
    return run_graph(graph, cache, wanted, known=known, processes=1)


def _missing(graph: Graph, cache: Cache, known: Mapping[str, Result]) -> list[tuple[Step, str]]:
    """Steps that are neither at hand nor stored but could be built now, with their keys."""
    contents: dict[str, str] = {}
    found = []
    for step in graph:
        if step.name in known:
            contents[step.name] = known[step.name].record.content
        elif all(name in contents for name in step.inputs):
            entry = stored(step, cache, contents, thorough=False)
            if entry is None:
                found.append((step, step.key(contents)))
            else:
                contents[step.name] = entry.facts["content"]
    return found
