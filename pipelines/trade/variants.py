"""Variants of a scene: built through the same cached stages as any run, with what each stage cost when it was built."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from pipelines.build import Observer, Outcome, run_graph
from pipelines.cache import Cache
from pipelines.chain import scene_stages
from pipelines.scene_file import LoadedScene, changed
from pipelines.stages import Graph, Stage
from pipelines.study import add_stages
from pipelines.trade.probes import PROBES, Value

COMPILE_SECONDS = 0.01  # of motion, long enough to compile a time loop


@dataclass(frozen=True, kw_only=True)
class Measured:
    """The values of a variant and its cost; a stage that was reused counts with what building it took."""

    by_probe: Mapping[str, tuple[Value, ...]]
    seconds: dict[str, float]  # by stage
    peak_bytes: int

    @property
    def values(self) -> tuple[Value, ...]:
        """Of all probes."""
        return tuple(value for values in self.by_probe.values() for value in values)

    @property
    def total_seconds(self) -> float:
        """Sum over the stages."""
        return sum(self.seconds.values())


def measure(
    scenes: Mapping[str, LoadedScene],
    probes: Sequence[str],
    cache: Cache,
    *,
    observer: Observer | None = None,
    processes: int | None = None,
) -> dict[str, Measured]:
    """Build what the named probes need of every scene, each distinct stage once, and read them; by variant.

    Raises
    ------
    SceneError, InputError, WorkError : a scene cannot be used, or a stage failed
    """
    stages: list[Stage] = []
    names, wanted = {}, {}
    for variant, loaded in scenes.items():
        new = scene_stages(loaded.scene, loaded.source.shown)
        names[variant] = add_stages(stages, new, f"{variant}: ")
        needed = [name for probe in probes for name in PROBES[probe].stages(loaded.scene)]
        wanted[variant] = Graph(new).needed(needed).stages
    graph = Graph(stages)
    every = dict.fromkeys(names[variant][stage] for variant, needed in wanted.items() for stage in needed)
    outcome = run_graph(graph, cache, every, observer=observer, processes=processes)
    return {
        variant: _measured(loaded, probes, {stage: names[variant][stage] for stage in wanted[variant]}, outcome)
        for variant, loaded in scenes.items()
    }


def compile_ahead(scenes: Iterable[LoadedScene], cache: Cache) -> None:
    """Move every integrator of the scenes for some steps, so that no variant pays for compiling code."""
    kinds = {loaded.scene.simulation.integrator: loaded for loaded in scenes}
    for loaded in kinds.values():
        short = changed(loaded, {"simulation.end_s": COMPILE_SECONDS, "diagnosis.windows_s": {}})
        measure({"compile": short}, ["signals"], cache)


def _measured(loaded: LoadedScene, probes: Sequence[str], names: Mapping[str, str], outcome: Outcome) -> Measured:
    own = Outcome({stage: outcome.results[name] for stage, name in names.items()})
    distinct = {record.key: (stage, record) for stage, record in zip(own.results, own.records, strict=True)}
    return Measured(
        by_probe={probe: tuple(PROBES[probe].read(loaded.scene, own)) for probe in probes},
        seconds={stage: record.seconds for stage, record in distinct.values()},
        peak_bytes=max(record.peak_bytes for _, record in distinct.values()),
    )
