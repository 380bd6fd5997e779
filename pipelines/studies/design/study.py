"""A design study: from the options to the front, with its best candidates evaluated on a finer grid of positions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.gears.modifications import PairModifications
from pipelines.engine.run_graph import Work
from pipelines.io.errors import InputError
from pipelines.runs.single_results import scene_graph
from pipelines.scene.file import LoadedScene
from pipelines.steps.candidates import CandidateResults, Conditions
from pipelines.studies.design.quantities import Quantity, parse_limit, parse_quantity
from pipelines.studies.design.search import FINE, Designs, DesignTask, Evaluations, search
from pipelines.studies.design.variables import Variables, parse_vary

if TYPE_CHECKING:
    from pipelines.machine.plant import Plant

LOADS = (0.25, 0.5, 0.75, 1.0)  # of the torque of the scene
COMPROMISE = "compromise"
SHOWN = 8  # candidates of the front in tables


@dataclass(frozen=True, kw_only=True)
class DesignOptions:
    """What the user asks for; `torques` are N m on the pinion."""

    stage: int = 1
    vary: tuple[str, ...] = ()
    minimize: tuple[str, ...] = ("te",)
    limits: tuple[str, ...] = ()
    torques: tuple[float, ...] = ()
    samples: int = 0
    misalignment_um: float = 0.0
    seed: int = 1
    evaluations: int = 2000


@dataclass(frozen=True, eq=False, kw_only=True)
class DesignStudy:
    """The front of a stage, and its best candidates.

    names : of the candidates that tables and figures show: "unmodified", "scene" if that is modified, "A", "B", ...
    modifications : of each
    chosen : name of the compromise
    results : of each, with `FINE` positions in the mesh cycle
    """

    title: str
    designs: Designs
    names: tuple[str, ...]
    candidates: tuple[int | None, ...]
    modifications: tuple[PairModifications, ...]
    chosen: str
    results: CandidateResults

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Objectives, then quantities of the limits."""
        task = self.designs.task
        return tuple(dict.fromkeys([*task.objectives, *(limit.quantity for limit in task.limits)]))

    def rows(self) -> list[dict[str, Any]]:
        """A row for each shown candidate."""
        columns = [(one.label, one.of(self.results)) for one in self.quantities]
        keys = self.designs.task.variables.names
        return [
            {"design": name}
            | ({} if at is None else dict(zip(keys, self.designs.values(at), strict=True)))
            | {label: float(values[number]) for label, values in columns}
            for number, (name, at) in enumerate(zip(self.names, self.candidates, strict=True))
        ]

    def settings(self, name: str) -> str:
        """A candidate as settings of the command line."""
        designs = self.designs
        values = designs.values(self.candidates[self.names.index(name)] or 0)
        return " ".join(f"--set {key}={value}" for key, value in designs.task.variables.settings(values).items())

    def best(self) -> dict[str, str]:
        """Name of the best candidate of each objective, and of the compromise if it beats the unmodified pair in all.

        The values are those of the fine mesh cycle, as in the table.
        """
        values = np.stack([one.of(self.results) for one in self.designs.task.objectives], axis=1)
        first = self.names.index("A")
        found = {
            one.label: self.names[first + int(column.argmin())]
            for one, column in zip(self.designs.task.objectives, values[first:].T, strict=True)
        }
        better = (values[self.names.index(self.chosen)] < values[0]).all()
        return found | ({COMPROMISE: self.chosen} if better and len(found) > 1 else {})

    def edges(self, name: str) -> list[str]:
        """Keys of a candidate at an end of their range, except 0 and the length of a relief without amount."""
        designs = self.designs
        values = designs.values(self.candidates[self.names.index(name)] or 0)
        pairs = list(zip(designs.task.variables.given, values, strict=True))
        absent = {over.key.replace("amount_um", "length_mm") for over, value in pairs if not value}
        return [
            over.key
            for over, value in pairs
            if value and over.key not in absent and value in (min(over.values), max(over.values))
        ]


def design_study(loaded: LoadedScene, options: DesignOptions, work: Work) -> DesignStudy:
    """Search for the best modifications of a stage.

    Raises
    ------
    SceneError, InputError : the scene or an option cannot be used, or nothing meets the limits
    """
    graph, machine = scene_graph(loaded)
    task = _task(loaded, machine, options)
    evaluate = Evaluations(task, graph, machine.sound_law_names[options.stage - 1], work)
    designs = search(evaluate, task, quiet=work.quiet)
    given = machine.layout.modifications[options.stage - 1]
    involute = PairModifications(misalignment=given.misalignment)
    known: dict[str, tuple[int | None, PairModifications]] = {"unmodified": (None, involute)}
    if given != involute:
        known["scene"] = None, given
    shown = _shown(designs)
    for number, at in enumerate(shown):
        known[chr(ord("A") + number)] = at, task.variables.modifications(designs.values(at))
    fine = replace(evaluate.conditions, positions=FINE)
    pair, names = task.conditions.pair, tuple(known)
    return DesignStudy(
        title=f"{loaded.scene.title}: stage {options.stage}, {pair.pinion.teeth}/{pair.wheel.teeth} teeth",
        designs=designs,
        names=names,
        candidates=tuple(at for at, _ in known.values()),
        modifications=tuple(one for _, one in known.values()),
        chosen=chr(ord("A") + shown.index(designs.compromise)),
        results=evaluate.results([one for _, one in known.values()], fine),
    )


def _shown(designs: Designs) -> list[int]:
    """About `SHOWN` candidates of the front: spread along it, the best of each objective, the compromise."""
    front = designs.front.tolist()
    if len(front) <= SHOWN:
        return front
    best = designs.objectives[designs.front].argmin(axis=0)
    spread = np.linspace(0, len(front) - 1, max(SHOWN - 1 - best.size, 1)).round().astype(int)
    at = np.unique([*spread, *best, front.index(designs.compromise)])
    return [front[i] for i in at]


def _task(loaded: LoadedScene, machine: Plant, options: DesignOptions) -> DesignTask:
    count = len(machine.layout.pairs)
    if not 1 <= options.stage <= count:
        raise InputError(f"--stage {options.stage}: the scene has {count} stages. Set a number from 1 to {count}.")
    number = options.stage - 1
    pair, sense = machine.flanks[number].pair, machine.layout.pinion_senses[number]
    radius, scene_force = pair.pinion.base_radius, machine.facts.stages[number].shown_force
    torques = tuple(sorted(set(options.torques))) or tuple(share * scene_force * radius for share in LOADS)
    forces = tuple(torque / radius for torque in torques)
    sampled = options.samples > 0
    return DesignTask(
        variables=Variables(loaded, options.stage, sense, tuple(map(parse_vary, options.vary))),
        objectives=tuple(parse_quantity(text, sampled=sampled) for text in dict.fromkeys(options.minimize)),
        limits=tuple(parse_limit(text, sampled=sampled) for text in options.limits),
        conditions=Conditions(
            pair=pair,
            forces=forces,
            samples=tuple(range(options.seed, options.seed + options.samples)),
            grade=loaded.scene.deviations.iso_grade,
            misalignment=1e-6 * options.misalignment_um,
        ),
        torques=torques,
        seed=options.seed,
        evaluations=options.evaluations,
    )
