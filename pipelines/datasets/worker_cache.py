"""Worker cache: mesh laws, casings and systems that a process keeps between the scenes it simulates.

A missing law or casing is built by one process and shared through the cache. While another process builds it, a
process builds other missing parts of its scene, and waits only if there are none.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from typing import Any

from mbd.system.system import System
from pipelines.engine.build_step import Result
from pipelines.engine.cache import Cache
from pipelines.engine.run_graph import Outcome, run_graph
from pipelines.engine.step import Graph, stored_contents
from pipelines.engine.storage import digest
from pipelines.machine.machine_model import MachineModel
from pipelines.steps.machine_steps import machine_steps
from pipelines.steps.motion import MotionSpec, assembled

_MOST_VALUES = 16  # laws and casings
_MOST_SYSTEMS = 2
_WAIT_SECONDS = 0.1


class WorkerCache:
    """Systems of machine models, assembled from stored results; equal parts are read once, equal systems built once."""

    def __init__(self, cache: Cache) -> None:
        self._cache = cache
        self._values: OrderedDict[str, Any] = OrderedDict()  # by the digest of their content
        self._systems: OrderedDict[str, System] = OrderedDict()

    def system(self, machine: MachineModel) -> System:
        """The system of a machine in its casing; missing laws and casings are built.

        Raises
        ------
        any error of a step
        """
        graph = Graph(machine_steps(machine))
        motion = graph.steps["simulate"]
        spec: MotionSpec = motion.spec
        contents = self._contents(graph, motion.inputs)
        made_of = (spec.machine, spec.recorded, spec.motion.band, motion.received(contents.__getitem__))
        key = digest(made_of)
        if key not in self._systems:
            taken = motion.received(lambda name: self._values[contents[name]])
            self._systems[key] = assembled(spec, **taken)
        self._systems.move_to_end(key)
        _shorten(self._systems, _MOST_SYSTEMS)
        return self._systems[key]

    def _contents(self, graph: Graph, requested: tuple[str, ...]) -> dict[str, str]:
        """Digests of the requested results by name; their values are in memory afterwards."""
        known, _ = stored_contents(graph.needed(requested), self._cache, {})
        if any(known.get(name) not in self._values for name in requested):
            outcome = build_inputs(graph, requested, self._cache)
            for name in requested:
                known[name] = outcome.results[name].record.content
                self._values[known[name]] = outcome.value(name)
        contents = {name: known[name] for name in requested}
        for content in contents.values():
            self._values.move_to_end(content)
        _shorten(self._values, max(_MOST_VALUES, len(requested)))
        return contents


def _shorten(kept: OrderedDict[str, Any], most: int) -> None:
    while len(kept) > most:
        kept.popitem(last=False)


def build_inputs(graph: Graph, requested: Sequence[str], cache: Cache) -> Outcome:
    """Results of the requested steps and their inputs; each step is built by only one process.

    Parameters
    ----------
    graph, requested, cache : as in `pipelines.engine.run_graph.run_graph`

    Raises
    ------
    any error of a step
    """
    graph = graph.needed(requested)
    known: Mapping[str, Result] = {}
    while True:
        contents, missing = stored_contents(graph, cache, {name: one.record.content for name, one in known.items()})
        if not missing:
            return run_graph(graph, cache, requested, known=known, processes=1)
        for step in missing:
            with cache.alone(step.key(contents)) as mine:
                if mine:
                    known = {**known, **run_graph(graph, cache, [step.name], known=known, processes=1).results}
                    break
        else:
            time.sleep(_WAIT_SECONDS)
