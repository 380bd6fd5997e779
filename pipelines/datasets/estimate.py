"""What a campaign takes before it is run: scenes, distinct laws and casings, time and disk; what would be refused."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from pipelines.datasets.campaign_scenes import SampledScene, group_variables, group_words, scene_of
from pipelines.datasets.expressions import ExpressionError
from pipelines.datasets.labels import labels
from pipelines.datasets.plan import Plan
from pipelines.datasets.signal_layout import CASING_SIGNALS
from pipelines.engine.cache import Cache
from pipelines.engine.step import Graph, Step
from pipelines.engine.storage import digest
from pipelines.io.errors import SceneError
from pipelines.io.shown_text import duration
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.checks.cost import cost
from pipelines.machine.checks.cost import words as size_words
from pipelines.machine.checks.design_warnings import load_warnings, spall_warnings
from pipelines.machine.machine_model import MachineModel
from pipelines.steps.machine_steps import machine_steps

_PARTS = {  # words for kinds of step; {s} and {es}: endings of the plural
    "law": "mesh law{s}",
    "flanks": "mesh law{s} with faults or modifications",
    "crack-surface": "crack surface{s}",
    "casing": "casing{s}",
    "casing-mesh": "casing mesh{es}",
    "casing-modes": "set{s} of casing modes",
    "casing-coarser": "coarser casing{s}",
    "casing-error": "estimate{s} of the casing error",
    "casing-matrices": "casing{s} from matrices",
}
MOST_LOOKED_AT = 500  # scenes; of more the first ones are looked at
_SAMPLE_BYTES = 4  # of a stored sample; angles and speeds take twice as much and pack better
_STORED_SHARE = 0.9  # of the bytes that are left after packing: vibration is nearly noise


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What a campaign takes, as `gearcase campaign --dry-run` prints it.

    `labels` counts the scenes that were looked at; `refused` are the messages of those that cannot be run.
    """

    labels: Counter[str]
    refused: tuple[str, ...]
    text: str


def estimate(plan: Plan, sampled: Sequence[SampledScene]) -> Estimate:
    """Look at the scenes of a plan without simulating any.

    Raises
    ------
    SceneError : none of them can be run
    """
    cache = Cache()
    refused: list[SceneError | ExpressionError] = []
    distinct: dict[str, Step] = {}
    found: Counter[str] = Counter()
    doubtful: list[str] = []  # a warning of each scene whose label its signals may not show, or whose gears rattle
    seconds = size = 0.0
    looked = sampled[:MOST_LOOKED_AT]
    for one in looked:
        try:
            loaded = scene_of(plan, one.values)
            machine = checked_machine(loaded.scene, loaded.source.shown)
        except (SceneError, ExpressionError) as error:
            refused.append(error)
            continue
        found[labels(machine)["label"]] += 1
        doubtful += [*spall_warnings(machine), *load_warnings(loaded.scene, machine.layout)][:1]
        motion = cost(machine)
        seconds += motion.seconds
        size += _STORED_SHARE * _SAMPLE_BYTES * motion.samples * _stored_channels(plan, machine, motion.channels)
        graph = Graph(machine_steps(machine))
        for step in graph.needed(graph.steps["simulate"].inputs):
            distinct.setdefault(digest([step.kind, step.spec, [step.code]]), step)
    if not found:
        raise refused[0]
    runs, cores = len(sampled), os.cpu_count() or 1
    share = runs / len(looked)
    messages = tuple(" ".join(str(error).replace("\n", ";", 1).split()) for error in refused)
    different = len({json.dumps(one.values) for one in sampled})
    by = group_words(group_variables(plan.table))
    parts = Counter(one.split for one in sampled)
    kinds = Counter(_PARTS.get(step.kind, step.kind) for step in distinct.values())
    missing = sum(step.seconds for step in distinct.values() if not _stored(step, cache))
    files = 1 + len(plan.table.signals or CASING_SIGNALS)  # of a run: its row, and one of every signal
    part = "" if len(looked) == runs else f" (of the first {len(looked)} scenes)"
    lines = [
        f"scenes      {runs}{'' if different == runs else f', {different} of them distinct'}",
        f"labels      {_counted(found)}{part}",
        *([f"split       {_counted(parts)}; {by}"] if len(parts) > 1 else []),
        f"distinct    {_counted(kinds)}{part}",
        f"time        about {duration((missing + share * seconds) / cores)} on {cores} cores: "
        f"{duration(share * seconds)} of processor time for motions, {duration(missing)} for mesh laws and casings "
        "that are not in the cache",
        f"disk        about {size_words(share * size)} in {runs * files} files, {files} for each simulation",
    ]
    if doubtful:
        lines.append(f"doubtful    {len(doubtful)}{part}; the first: {doubtful[0]}")
    if messages:
        lines.append(f"refused     {len(messages)}{part}; the first: {messages[0]}")
    return Estimate(labels=found, refused=messages, text="".join(f"{line}\n" for line in lines))


def _stored_channels(plan: Plan, machine: MachineModel, channels: int) -> float:
    """About how many channels of four bytes are stored of a scene."""
    if plan.table.signals:
        return channels
    vibration = 3 * (len(machine.sensors) or len(machine.bearing_points))
    return vibration + 2 * len(machine.parts.shafts) + 3 * max(1, len(machine.parts.couplings))


def _stored(step: Step, cache: Cache) -> bool:
    """True if a result that needs no other is stored; one that does is counted as if it were not."""
    return not step.inputs and cache.find(step.kind, step.key({}), thorough=False) is not None


def _counted(counts: Counter[str]) -> str:
    return ", ".join(
        f"{count} {name.format(s='' if count == 1 else 's', es='' if count == 1 else 'es')}"
        for name, count in sorted(counts.items())
    )
