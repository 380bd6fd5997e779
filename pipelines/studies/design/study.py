"""A design study: from the options to the front, with its best candidates evaluated on a finer grid of positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.gears.modifications import PairModifications
from pipelines.engine.run_graph import Work
from pipelines.io.errors import InputError
from pipelines.runs.gear_numbers import machine_states
from pipelines.runs.single_results import scene_graph
from pipelines.scene.file import LoadedScene
from pipelines.steps.candidates import CandidateResults, Conditions
from pipelines.studies.design.quantities import Quantity, parse_limit, parse_quantity
from pipelines.studies.design.search import FINE, Designs, DesignTask, Evaluations, search
from pipelines.studies.design.variables import Variables, parse_vary

if TYPE_CHECKING:
    from pipelines.machine.plant import Plant

LOADS = (0.25, 0.5, 0.75, 1.0)  # of the torque of the scene
SHOWN = 8  # candidates of the front in tables


@dataclass(frozen=True, kw_only=True)
class DesignOptions:
    """What the user asks for; `torques` are N m on the pinion, `tilt` is in um over the face or "machine"."""

    stage: int = 1
    vary: tuple[str, ...] = ()
    minimize: tuple[str, ...] = ("te",)
    limits: tuple[str, ...] = ()
    torques: tuple[float, ...] = ()
    tilt: float | str = 0.0
    samples: int = 0
    grade: int | None = None  # without it: that of the scene
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
    conditions: Conditions
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

    def block(self) -> str:
        """The compromise as settings of the command line, one for each key."""
        variables = self.designs.task.variables
        settings = variables.settings(self.designs.values(self.designs.compromise))
        return "\n".join(f"--set {key}={value}" for key, value in settings.items())


def design_study(loaded: LoadedScene, options: DesignOptions, work: Work) -> DesignStudy:
    """Search for the best modifications of a stage.

    Raises
    ------
    SceneError, InputError : the scene or an option cannot be used, or nothing meets the limits
    """
    graph, machine = scene_graph(loaded)
    task = _task(loaded, machine, options, work)
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
        conditions=fine,
        results=evaluate.results([one for _, one in known.values()], fine),
    )


def _shown(designs: Designs) -> list[int]:
    """At most `SHOWN` candidates of the front, spread along it, both ends and the compromise among them."""
    front = designs.front.tolist()
    if len(front) <= SHOWN:
        return front
    at = np.unique([*np.linspace(0, len(front) - 1, SHOWN - 1).round().astype(int), front.index(designs.compromise)])
    return [front[i] for i in at]


def _task(loaded: LoadedScene, machine: Plant, options: DesignOptions, work: Work) -> DesignTask:
    count = len(machine.layout.pairs)
    if not 1 <= options.stage <= count:
        raise InputError(f"--stage {options.stage}: the scene has {count} stages. Set a number from 1 to {count}.")
    number = options.stage - 1
    pair, sense = machine.flanks[number].pair, machine.layout.pinion_senses[number]
    radius, scene_force = pair.pinion.base_radius, machine.facts.stages[number].shown_force
    torques = tuple(sorted(set(options.torques))) or tuple(share * scene_force * radius for share in LOADS)
    forces = tuple(torque / radius for torque in torques)
    if options.tilt == "machine":
        state = machine_states(loaded, work)[number]
        tilts: Sequence[float] = [float(state.tilt or 0.0) * force / state.force for force in forces]
    else:
        tilts = [sense * float(options.tilt) * 1e-6 / pair.face_width] * len(forces)
    sampled = options.samples > 0
    deviations = loaded.scene.deviations
    return DesignTask(
        variables=Variables(loaded, options.stage, sense, tuple(map(parse_vary, options.vary))),
        objectives=tuple(parse_quantity(text, sampled=sampled) for text in dict.fromkeys(options.minimize)),
        limits=tuple(parse_limit(text, sampled=sampled) for text in options.limits),
        conditions=Conditions(
            pair=pair,
            forces=forces,
            tilts=tuple(tilts),
            samples=tuple(range(options.seed, options.seed + options.samples)),
            grade=options.grade or deviations.iso_grade,
            misalignment=1e-6 * options.misalignment_um,
        ),
        torques=torques,
        seed=options.seed,
        evaluations=options.evaluations,
    )
