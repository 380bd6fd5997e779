"""A design study: from the options to the front, with its best candidates evaluated on a finer grid of positions."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.law import MeshLaw
from fem.gears.gear_checks import GeometryError
from fem.gears.geometry import GearPair
from fem.gears.modifications import LARGEST_PART, relief_lengths
from mbd.output.recorder import PASS_SHARE
from pipelines.engine.run_graph import Work
from pipelines.io.errors import InputError, SceneError, SceneWarning
from pipelines.machine.checks.strength import refuse_overload
from pipelines.runs.load_map import TORQUE_SHARES
from pipelines.scene.load_scene import LoadedScene, changed
from pipelines.steps.flank_candidates import CandidateResults, Conditions
from pipelines.studies.design.design_variables import Variables, parse_vary
from pipelines.studies.design.quantities import NOMINAL, RATIO_ERROR, Quantity, parse_limit, parse_quantity
from pipelines.studies.design.search import Candidate, Designs, DesignTask, Evaluations, compromise, search
from pipelines.studies.design.stage_pair import StagePair, stage_pair

if TYPE_CHECKING:
    import xarray


COMPROMISE = "compromise"
SHOWN = 8  # candidates of the front in tables
FINE = 256  # positions of the mesh cycle for them, as in `gearcase gears --plot`
MOST_AMOUNTS, MOST_LENGTHS = 40, 40  # of the reliefs that are compared if nothing is varied


@dataclass(frozen=True, kw_only=True)
class DesignOptions:
    """What is searched.

    stage : number of the stage, from 1
    vary : modifications and values of the stage, as ``both.tip_relief.amount_um=0:40:4``, ``face_width_mm=18:24:2``;
        none: tip reliefs of both gears
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
    pairs : of each, with its modifications
    results : of each, with `FINE` positions in the mesh cycle
    levels : a row for each (none without levels): by the linearised machine and by the time loop, at the scene's load
    evaluate : computes more of them

    >>> import gearcase
    >>> vary = ["both.tip_relief.amount_um=0:8:2", "both.tip_relief.length_mm=2,3,4"]
    >>> found = gearcase.design(gearcase.Scene.from_file("pair"), vary, torques=[50.0])
    >>> found.names, len(found.designs.index), found.best()
    (('unmodified', 'A'), 15, {'te um': 'A'})
    >>> found.settings("A")["stages.1.wheel.tip_relief.length_mm"]
    3
    """

    title: str
    designs: Designs
    names: tuple[str, ...]
    candidates: tuple[int | None, ...]
    pairs: tuple[Candidate, ...]
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
        """Name of the best candidate of each objective, and of the compromise if one beats the unmodified pair in all.

        The values are those of the fine mesh cycle, as in the table.
        """
        values = np.stack([one.of(self.results) for one in self.designs.task.objectives], axis=1)
        first = self.names.index("A")
        found = {
            one.label: self.names[first + int(column.argmin())]
            for one, column in zip(self.designs.task.objectives, values[first:].T, strict=True)
        }
        at = compromise(values[first:], values[0])
        return found | ({} if at is None or len(found) == 1 else {COMPROMISE: self.names[first + at]})

    @property
    def recommended(self) -> str:
        """Name of the compromise, or else of the best candidate of the first objective."""
        found = self.best()
        return found.get(COMPROMISE) or next(iter(found.values()))

    def load_map(self, name: str) -> xarray.Dataset:
        """A candidate and its gears without modifications over the torque, as `gearcase gears --map` gives it.

        Takes about 9 s for the root stresses.
        """
        pair, modifications = self.pairs[self.names.index(name)]
        states = {} if modifications == pair.involute else {"unmodified": pair.involute}
        return self.evaluate.load_map(pair, states | {f"design {name}": modifications})

    def exceeded(self, name: str) -> list[str]:
        """Limits that a candidate exceeds on the fine mesh cycle."""
        at = self.names.index(name)
        limits = self.designs.task.limits
        return [
            f"{one.quantity.label} <= {one.most:g}" for one in limits if one.quantity.of(self.results)[at] > one.most
        ]

    def edges(self, name: str) -> list[str]:
        """Keys of a candidate at an end of their range beyond which there are other designs.

        These are not a fixed value, 0, the start of a relief without amount, and half of the path of contact, see
        `relief_lengths`.
        """
        pairs = list(zip(self.designs.task.variables.given, self._values(name), strict=True))
        absent = tuple(over.key.removesuffix("amount_um") for over, value in pairs if not value)
        longest = 1e3 * relief_lengths(self.designs.task.conditions.pair)[1]
        return [
            over.key
            for over, value in pairs
            if value
            and len(over.values) > 1
            and not over.key.startswith(absent)
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
    _check(loaded, options)
    healthy = {"faults": [], "deviations.enabled": False}
    scene = stage_pair(changed(loaded, healthy), options.stage)
    laws: tuple[MeshLaw, MeshLaw] = work.build(scene.graph, [scene.takes["laws"]]).value(scene.takes["laws"])
    task = _task(loaded, scene, options, laws[0])
    evaluate = Evaluations(task, scene, _pairs(changed(loaded, healthy), scene, task), work)
    if evaluate.of_levels:
        work.build(scene.graph, [scene.takes["response"]])
    designs = search(evaluate, task, quiet=work.quiet)
    fixed: dict[str, Candidate] = {"unmodified": (scene, scene.involute)}
    if scene.given != scene.involute:
        fixed["scene"] = scene, scene.given
    shown = _shown(designs, task.judged(evaluate.results([fixed["unmodified"]]))[0])
    found = [one for at in shown if (one := evaluate.candidate(designs.index[at])) is not None]  # all: of the front
    results = evaluate.results([*fixed.values(), *found], positions=FINE)
    objectives, excess = (values[len(fixed) :] for values in task.judged(results))
    front = Designs(task=task, index=designs.index[shown], objectives=objectives, excess=excess).front
    kept = front if front.size else np.arange(len(shown))  # if none meets the limits on the finer positions
    pairs = fixed | {chr(letter): found[at] for letter, at in enumerate(kept, ord("A"))}
    return DesignStudy(
        title=f"{loaded.scene.title}: stage {options.stage}, {scene.pair.label.removeprefix('gear pair ')} teeth",
        designs=designs,
        names=tuple(pairs),
        candidates=(*(None for _ in fixed), *(shown[at] for at in kept)),
        pairs=tuple(pairs.values()),
        evaluate=evaluate,
        results=CandidateResults.joined([results], np.array([*range(len(fixed)), *(len(fixed) + kept)])),
        levels=_levels(evaluate, task, pairs, work) if evaluate.of_levels else (),
    )


def _pairs(loaded: LoadedScene, scene: StagePair, task: DesignTask) -> dict[tuple[int, ...], StagePair]:
    """The pairs of all values of the stage that can be used and meet the limits of the ratio, by their numbers.

    Raises
    ------
    SceneError, InputError : there is none
    """
    variables, found, most = task.variables, dict[tuple[int, ...], StagePair](), math.inf
    if not variables.stage_columns:
        return {(): scene}
    for limit in task.limits:
        most = min(most, limit.most) if limit.quantity.name == RATIO_ERROR else most
    left_out: list[Exception] = []
    for index in itertools.product(*(range(variables.sizes[column]) for column in variables.stage_columns)):
        try:
            other = changed(loaded, variables.stage_settings(index))
            table = other.scene.stages[scene.stage - 1]
            if 100 * abs(table.wheel_teeth / table.pinion_teeth / scene.pair.ratio - 1) <= most:
                found[index] = stage_pair(other, scene.stage)
        except (SceneError, GeometryError) as error:
            left_out.append(error)
    if not found:
        none = InputError(f"design: no numbers of teeth meet the limit of {RATIO_ERROR}. Extend the ranges.")
        raise left_out[0] if left_out else none
    if left_out:
        warnings.warn(
            f"{len(left_out)} sets of values of the stage are no gear pairs of this machine and are left out. The "
            f"first: {left_out[0]}",
            SceneWarning,
            stacklevel=3,
        )
    return found


def _levels(
    evaluate: Evaluations, task: DesignTask, pairs: Mapping[str, Candidate], work: Work
) -> tuple[dict[str, Any], ...]:
    """Rows of `DesignStudy.levels`."""
    conditions = {"samples": (), "loaded": (), "positions": FINE}
    linearised = evaluate.results(tuple(pairs.values()), at_scene=True, **conditions)
    simulated = replace(linearised, levels=evaluate.simulated_levels(pairs, work)[:, None, None])
    columns = {"te um": Quantity(name="te", statistic=NOMINAL).of(linearised)}
    for one in {one.name: replace(one, statistic=NOMINAL) for one in task.quantities if one.of_level}.values():
        columns[f"{one.name} linearised m/s2"] = one.of(linearised)
        columns[f"{one.name} time loop m/s2"] = found = one.of(simulated)
        columns[f"{one.name} change dB"] = 20 * np.log10(found / found[0])
    return tuple(
        {"design": name} | {key: float(values[number]) for key, values in columns.items()}
        for number, name in enumerate(pairs)
    )


def _shown(designs: Designs, unmodified: np.ndarray) -> list[int]:
    """About `SHOWN` candidates of the front: spread along it, the best of each objective, the compromise."""
    front = designs.front.tolist()
    if len(front) <= SHOWN:
        return front
    values = designs.objectives[designs.front]
    best, middle = values.argmin(axis=0), compromise(values, unmodified)
    spread = np.linspace(0, len(front) - 1, max(SHOWN - 1 - best.size, 1)).round().astype(int)
    at = np.unique([*spread, *best, *([] if middle is None else [middle])])
    return [front[i] for i in at]


def _check(loaded: LoadedScene, options: DesignOptions) -> None:
    if options.misalignment and not options.samples:
        raise InputError(
            f"misalignment = {1e6 * options.misalignment:g} um: is that of pairs with deviations. Set --samples 20."
        )
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


def _task(loaded: LoadedScene, scene: StagePair, options: DesignOptions, law: MeshLaw) -> DesignTask:
    machine, layout, pair, sampled = scene.machine, scene.machine.layout, scene.pair, options.samples > 0
    radius, number = pair.pinion.base_radius, options.stage - 1
    for torque in options.torques:
        refuse_overload(options.stage, pair, torque)
    torques = tuple(sorted(set(options.torques))) or tuple(share * scene.force * radius for share in TORQUE_SHARES)
    forces = tuple(torque / radius for torque in torques)
    deflection = stiffness_curve(law, forces[-1]).transmission_error.max()  # warns if the law ends too early
    vary = options.vary or _tip_reliefs(pair, deflection)
    highest = PASS_SHARE * machine.motion.output_rate
    possible = machine.monitored.speed_is_known and machine.facts.stages[number].mesh_frequency <= highest
    sensors = machine.recorded.sensors if possible else ()
    given = tuple(map(parse_vary, vary))
    return DesignTask(
        variables=Variables(loaded, options.stage, layout.pinion_senses[number], layout.pairs[number], given),
        objectives=tuple(parse_quantity(text, sensors, sampled=sampled) for text in dict.fromkeys(options.minimize)),
        limits=tuple(parse_limit(text, sensors, sampled=sampled) for text in options.limits),
        conditions=Conditions(
            pair=pair,
            forces=forces,
            samples=tuple(range(options.seed, options.seed + options.samples)),
            grade=loaded.scene.deviations.iso_grade if loaded.scene.deviations.include else None,
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
