"""A design study: from the options to the front, with its best candidates evaluated on a finer grid of positions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.law import MeshLaw
from fem.gears.geometry import GearPair
from fem.gears.modifications import LARGEST_PART, PairModifications, relief_lengths
from pipelines.engine.run_graph import Work
from pipelines.engine.step import Graph
from pipelines.io.errors import InputError
from pipelines.runs.load_map import TORQUE_SHARES
from pipelines.runs.root_stress import root_step
from pipelines.runs.single_results import scene_graph
from pipelines.scene.load_scene import LoadedScene, changed
from pipelines.steps.flank_candidates import CandidateResults, Conditions
from pipelines.steps.mesh_response import response_step
from pipelines.studies.design.flank_variables import Variables, parse_vary
from pipelines.studies.design.quantities import NOMINAL, Quantity, parse_limit, parse_quantity
from pipelines.studies.design.search import Designs, DesignTask, Evaluations, search

if TYPE_CHECKING:
    import xarray

    from pipelines.machine.machine_model import MachineModel

COMPROMISE = "compromise"
SHOWN = 8  # candidates of the front in tables
FINE = 256  # positions of the mesh cycle for them, as in `gearcase gears --plot`
MOST_AMOUNTS, MOST_LENGTHS = 40, 40  # of the reliefs that are compared if nothing is varied


@dataclass(frozen=True, kw_only=True)
class DesignOptions:
    """What is searched.

    stage : number of the stage, from 1
    vary : modifications with their values, as ``both.tip_relief.amount_um=0:40:4``; none: tip reliefs of both gears
    minimize, limits : objectives and limits, as ``te``, ``pressure <= 1200``
    torques : N m on the pinion; none: 25, 50, 75 and 100 % of that of the scene
    samples : number of pairs with random deviations
    misalignment : m, largest misalignment of the samples over the face width
    seed : of search and deviations
    evaluations : number of candidates up to which all are evaluated
    """

    stage: int = 1
    vary: Sequence[str] = ()
    minimize: Sequence[str] = ("te",)
    limits: Sequence[str] = ()
    torques: Sequence[float] = ()
    samples: int = 0
    misalignment: float = 0.0
    seed: int = 1
    evaluations: int = 2000


@dataclass(frozen=True, eq=False, kw_only=True)
class DesignStudy:
    """The Pareto front of a stage, and its best candidates.

    title : scene, stage, teeth
    designs : all candidates
    names : of the candidates in tables and figures: "unmodified", "scene" if that is modified, "A", "B", ...
    candidates : of each its number in `designs`, None for the first ones
    modifications : of each
    results : of each, with `FINE` positions in the mesh cycle
    levels : a row for each at the load of the scene, its levels by the linearised machine and by the time loop; empty
        if no quantity is a level
    evaluate : computes more of them

    >>> import gearcase
    >>> vary = ["both.tip_relief.amount_um=0:8:2", "both.tip_relief.length_mm=2,3,4"]
    >>> found = gearcase.design(gearcase.Scene.from_file("pair"), vary, torques=[50.0])
    >>> found.names, len(found.designs.index), found.best()
    (('unmodified', 'A'), 15, {'te um': 'A'})
    >>> found.settings("A")["stages.1.wheel.tip_relief.length_mm"]
    4
    """

    title: str
    designs: Designs
    names: tuple[str, ...]
    candidates: tuple[int | None, ...]
    modifications: tuple[PairModifications, ...]
    results: CandidateResults
    levels: tuple[dict[str, Any], ...]
    evaluate: Evaluations

    def rows(self) -> list[dict[str, Any]]:
        """A row for each named candidate: its values and quantities."""
        columns = [(one.label, one.of(self.results)) for one in self.designs.task.quantities]
        keys = self.designs.task.variables.names
        return [
            {"design": name}
            | ({} if at is None else dict(zip(keys, self.designs.values(at), strict=True)))
            | {label: float(values[number]) for label, values in columns}
            for number, (name, at) in enumerate(zip(self.names, self.candidates, strict=True))
        ]

    def settings(self, name: str) -> dict[str, Any]:
        """Keys of the scene with the values of the candidate "A", "B", ..."""
        return self.designs.task.variables.settings(self._values(name))

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
        at = self.candidates.index(self.designs.compromise)
        better = (values[at] < values[0]).all()
        return found | ({COMPROMISE: self.names[at]} if better and len(found) > 1 else {})

    @property
    def recommended(self) -> str:
        """Name of the compromise, or else of the best candidate of the first objective."""
        found = self.best()
        return found.get(COMPROMISE) or next(iter(found.values()))

    def load_map(self, name: str) -> xarray.Dataset:
        """The unmodified pair and a candidate over the torque, without deviations, as `gearcase gears --map` gives it.

        Takes about 9 s for the root stresses.
        """
        states = {f"design {name}" if one == name else one: self.modifications[self.names.index(one)]
                  for one in ("unmodified", name)}  # fmt: skip
        return self.evaluate.load_map(states, self.designs.task.variables.sense)

    def exceeded(self, name: str) -> list[str]:
        """Limits that a candidate exceeds on the fine mesh cycle."""
        at = self.names.index(name)
        limits = self.designs.task.limits
        return [
            f"{one.quantity.label} <= {one.most:g}" for one in limits if one.quantity.of(self.results)[at] > one.most
        ]

    def edges(self, name: str) -> list[str]:
        """Keys of a candidate at an end of their range beyond which there are other designs.

        These are not 0, the length of a relief without amount, and half of the path of contact, see `relief_lengths`.
        """
        pairs = list(zip(self.designs.task.variables.given, self._values(name), strict=True))
        absent = {over.key.replace("amount_um", "length_mm") for over, value in pairs if not value}
        longest = 1e3 * relief_lengths(self.designs.task.conditions.pair)[1]
        return [
            over.key
            for over, value in pairs
            if value
            and over.key not in absent
            and value in (min(over.values), max(over.values))
            and not (over.key == "both.tip_relief.length_mm" and value >= longest)
        ]

    def _values(self, name: str) -> list[Any]:
        at = self.candidates[self.names.index(name)]
        assert at is not None  # a candidate of the search
        return self.designs.values(at)


def design_study(loaded: LoadedScene, options: DesignOptions, work: Work) -> DesignStudy:
    """Search for the best modifications of a stage.

    Raises
    ------
    SceneError, InputError : the scene or an option cannot be used, or nothing meets the limits
    """
    number = _checked(loaded, options)
    graph, machine = scene_graph(changed(loaded, {"faults": [], "deviations.enabled": False}))
    law = machine.healthy_law_names[number]
    laws: tuple[MeshLaw, MeshLaw] = work.build(graph, [law]).value(law)
    task = _task(loaded, machine, options, laws[0])
    response = None
    if any(one.of_level for one in task.quantities):
        response = response_step(machine, graph.steps["simulate"], options.stage, law)
        work.build(Graph([*graph, response]), [response.name])
    evaluate = Evaluations(task, graph, law, root_step(machine, options.stage), response, work)
    designs = search(evaluate, task, quiet=work.quiet)
    given = machine.layout.modifications[number]
    involute = PairModifications(misalignment=given.misalignment)
    known: dict[str, tuple[int | None, PairModifications]] = {"unmodified": (None, involute)}
    if given != involute:
        known["scene"] = None, given
    for letter, at in enumerate(_shown(designs), ord("A")):
        known[chr(letter)] = at, task.variables.modifications(designs.values(at))
    force = machine.facts.stages[number].shown_force
    pair, modifications = task.conditions.pair, {name: one for name, (_, one) in known.items()}
    return DesignStudy(
        title=f"{loaded.scene.title}: stage {options.stage}, {pair.pinion.teeth}/{pair.wheel.teeth} teeth",
        designs=designs,
        names=tuple(known),
        candidates=tuple(at for at, _ in known.values()),
        modifications=tuple(modifications.values()),
        evaluate=evaluate,
        results=evaluate.results(tuple(modifications.values()), replace(evaluate.conditions, positions=FINE)),
        levels=() if response is None else _levels(evaluate, task, modifications, force, work),
    )


def _levels(
    evaluate: Evaluations,
    task: DesignTask,
    states: Mapping[str, PairModifications],
    force: float,
    work: Work,
) -> tuple[dict[str, Any], ...]:
    """Rows of `DesignStudy.levels` at a force, N."""
    conditions = replace(evaluate.conditions, forces=(force,), samples=(), loaded=(), positions=FINE)
    linearised = evaluate.results(tuple(states.values()), conditions)
    simulated = replace(linearised, levels=evaluate.simulated_levels(states, work)[:, None, None])
    columns = {"te um": Quantity(name="te", statistic=NOMINAL).of(linearised)}
    for one in {one.name: replace(one, statistic=NOMINAL) for one in task.quantities if one.of_level}.values():
        columns[f"{one.name} linearised m/s2"] = one.of(linearised)
        columns[f"{one.name} time loop m/s2"] = found = one.of(simulated)
        columns[f"{one.name} change dB"] = 20 * np.log10(found / found[0])
    return tuple(
        {"design": name} | {key: float(values[number]) for key, values in columns.items()}
        for number, name in enumerate(states)
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


def _checked(loaded: LoadedScene, options: DesignOptions) -> int:
    stages = loaded.scene.stages
    if not 1 <= options.stage <= len(stages):
        allowed = f"a number from 1 to {len(stages)}" if len(stages) > 1 else "1, the only stage of the scene"
        raise InputError(f"--stage {options.stage}: there is no such stage. Set {allowed}.")
    if stages[options.stage - 1].mesh.model == "iso":
        raise InputError(
            f'stages.{options.stage}.mesh.model = "iso": this model does not contain the effect of modifications on '
            'load sharing. Set "plane" or "solid".'
        )
    least = {"samples": 0, "misalignment": 0, "seed": 0, "evaluations": 1}
    for name, value in [(key, getattr(options, key)) for key in least] + [("torques", one) for one in options.torques]:
        if not least.get(name, 1e-6) <= value < math.inf:
            raise InputError(f"{name} = {value}: must be a number of at least {least.get(name, 1e-6):g}.")
    return options.stage - 1


def _task(loaded: LoadedScene, machine: MachineModel, options: DesignOptions, law: MeshLaw) -> DesignTask:
    number, sampled = options.stage - 1, options.samples > 0
    pair, sense = machine.flanks[number].pair, machine.layout.pinion_senses[number]
    radius, scene_force = pair.pinion.base_radius, machine.facts.stages[number].shown_force
    torques = tuple(sorted(set(options.torques))) or tuple(share * scene_force * radius for share in TORQUE_SHARES)
    forces = tuple(torque / radius for torque in torques)
    deflection = stiffness_curve(law, forces[-1]).transmission_error.max()  # warns if the law ends too early
    vary = options.vary or _tip_reliefs(pair, deflection)
    sensors = machine.recorded.sensors if machine.monitored.speed_is_known else ()
    return DesignTask(
        variables=Variables(loaded, options.stage, sense, tuple(map(parse_vary, vary))),
        objectives=tuple(parse_quantity(text, sensors, sampled=sampled) for text in dict.fromkeys(options.minimize)),
        limits=tuple(parse_limit(text, sensors, sampled=sampled) for text in options.limits),
        conditions=Conditions(
            pair=pair,
            forces=forces,
            samples=tuple(range(options.seed, options.seed + options.samples)),
            grade=loaded.scene.deviations.iso_grade,
            misalignment=options.misalignment,
        ),
        torques=torques,
        seed=options.seed,
        evaluations=options.evaluations,
    )


def _tip_reliefs(pair: GearPair, deflection: float) -> tuple[str, str]:
    """Linear tip reliefs, equal on both gears, in manufacturing steps.

    The amounts end at the largest deflection of the teeth without modifications, the effective tip relief C_eff of
    ISO/TS 6336-22 with the computed stiffness, and at the limit of the key. For the lengths see `relief_lengths`.
    """
    most = min(math.ceil(1e6 * deflection), int(1e6 * LARGEST_PART * pair.pinion.normal_module))
    amount_step = -(-most // MOST_AMOUNTS)
    short, long = (max(1, math.ceil(1e4 * length)) for length in relief_lengths(pair))  # in steps of 0.1 mm
    length_step = -(-(long - short) // MOST_LENGTHS)
    return (
        f"both.tip_relief.amount_um=0:{most}:{amount_step}",
        f"both.tip_relief.length_mm={short / 10}:{(long + length_step - 1) / 10}:{length_step / 10}",
    )
