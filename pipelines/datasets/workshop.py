"""What a process that simulates one scene after the other keeps between them: laws, casings, the last machine.

A missing law or casing is built by one process alone and shared through the cache. A process that finds one taken goes
on with another one of its scene, and waits only when nothing else is left to build.
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
from pipelines.machine.plant import Plant
from pipelines.steps.graph import plant_steps
from pipelines.steps.motion import MotionSpec, assembled

_MOST_VALUES = 16  # laws and casings
_MOST_SYSTEMS = 2
_WAIT_SECONDS = 0.1


class Workshop:
    """Makes the systems of plants; what two of them share is read, and what is equal assembled, once."""

    def __init__(self, cache: Cache) -> None:
        self._cache = cache
        self._values: OrderedDict[str, Any] = OrderedDict()  # by the digest of their content
        self._systems: OrderedDict[str, System] = OrderedDict()

    def system(self, plant: Plant) -> System:
        """The machine of a plant in its casing; what it is made of is built if no process has built it yet.

        Raises
        ------
        whatever a step raises
        """
        graph = Graph(plant_steps(plant))
        motion = graph.steps["simulate"]
        spec: MotionSpec = motion.spec
        contents = self._contents(graph, motion.inputs)
        machine = (spec.machine, spec.recorded, spec.motion.band, motion.received(contents.__getitem__))
        key = digest(machine)
        if key not in self._systems:
            taken = motion.received(lambda name: self._values[contents[name]])
            self._systems[key] = assembled(spec, **taken)
        self._systems.move_to_end(key)
        _shorten(self._systems, _MOST_SYSTEMS)
        return self._systems[key]

    def _contents(self, graph: Graph, wanted: tuple[str, ...]) -> dict[str, str]:
        """Digests of the wanted results by name, whose values are at hand then."""
        known, _ = stored_contents(graph.needed(wanted), self._cache, {})
        if any(known.get(name) not in self._values for name in wanted):
            outcome = build_inputs(graph, wanted, self._cache)
            for name in wanted:
                known[name] = outcome.results[name].record.content
                self._values[known[name]] = outcome.value(name)
        contents = {name: known[name] for name in wanted}
        for content in contents.values():
            self._values.move_to_end(content)
        _shorten(self._values, max(_MOST_VALUES, len(wanted)))
        return contents


def _shorten(kept: OrderedDict[str, Any], most: int) -> None:
    while len(kept) > most:
        kept.popitem(last=False)


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
    while True:
        contents, missing = stored_contents(graph, cache, {name: one.record.content for name, one in known.items()})
        if not missing:
            return run_graph(graph, cache, wanted, known=known, processes=1)
        for step in missing:
            with cache.alone(step.key(contents)) as mine:
                if mine:
                    known = {**known, **run_graph(graph, cache, [step.name], known=known, processes=1).results}
                    break
        else:
            time.sleep(_WAIT_SECONDS)
