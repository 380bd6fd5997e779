"""Variants of a scene: built through the same cached stages as any run, with what each stage cost when it was built."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipelines.build import Observer, run_graph
from pipelines.cache import Cache
from pipelines.scene_file import LoadedScene
from pipelines.study import plan_study
from pipelines.trade.probes import PROBES, Value


@dataclass(frozen=True, kw_only=True)
class Measured:
    """The values of a variant and its cost; a stage that was reused counts with what building it took."""

    values: tuple[Value, ...]
    seconds: dict[str, float]  # by stage
    peak_bytes: int

    @property
    def total_seconds(self) -> float:
        """Sum over the stages."""
        return sum(self.seconds.values())


def measure(loaded: LoadedScene, probes: Sequence[str], cache: Cache, *, observer: Observer | None = None) -> Measured:
    """Build what the named probes need of a scene, and read them.

    Raises
    ------
    SceneError, InputError, WorkError : the scene cannot be used, or a stage failed
    """
    scene = loaded.scene
    graph = plan_study(loaded, with_control=False, both_loads=False).graph
    wanted = list(dict.fromkeys(name for probe in probes for name in PROBES[probe].stages(scene)))
    outcome = run_graph(graph, cache, wanted, observer=observer)
    values = tuple(value for probe in probes for value in PROBES[probe].read(scene, outcome))
    return Measured(
        values=values,
        seconds={record.name: record.seconds for record in outcome.records},
        peak_bytes=max(record.peak_bytes for record in outcome.records),
    )
