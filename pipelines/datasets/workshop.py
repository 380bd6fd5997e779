"""What a process that simulates one scene after the other keeps between them: laws, casings, the last machine."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

from mbd.system.system import System
from pipelines.datasets.inputs import build_inputs
from pipelines.engine.cache import Cache
from pipelines.engine.step import Graph, stored
from pipelines.engine.storage import digest
from pipelines.machine.plant import Plant
from pipelines.steps.graph import plant_steps
from pipelines.steps.motion import MotionSpec, assembled

_MOST_VALUES = 16  # laws and casings
_MOST_SYSTEMS = 2


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
        known: dict[str, str] = {}
        for step in graph.needed(wanted):
            if all(name in known for name in step.inputs):
                entry = stored(step, self._cache, known, thorough=False)
                if entry is not None:
                    known[step.name] = entry.facts["content"]
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
