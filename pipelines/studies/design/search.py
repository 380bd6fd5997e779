"""Search for the best flank modifications of a stage: exhaustive if affordable, else by a genetic algorithm (NSGA-II).

Values are indices of manufacturing steps, so every candidate is evaluated as it would be made. Each batch of candidates
is a step whose result is stored; a repeated or interrupted search reads it again and continues.

References
----------
Deb, Pratap, Agarwal, Meyarivan 2002, IEEE Trans. Evol. Comput. 6(2), 182-197 (NSGA-II);
Blank, Deb 2020, IEEE Access 8, 89497-89509 (pymoo)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.contact.faults.changed_law import modified_law
from fem.gears.modifications import PairModifications
from pipelines.engine.progress import reported_count
from pipelines.engine.remaining import expected
from pipelines.engine.run_graph import Work
from pipelines.engine.step import Graph, Step
from pipelines.io.errors import InputError
from pipelines.io.shown_text import duration
from pipelines.runs.load_map import load_map
from pipelines.steps import flank_candidates, mesh_response
from pipelines.steps.flank_candidates import LOADED, CandidateResults, Conditions
from pipelines.studies.design.design_variables import Variables
from pipelines.studies.design.quantities import RATIO_ERROR, Limit, Quantity
from pipelines.studies.design.stage_pair import StagePair

if TYPE_CHECKING:
    import xarray

POPULATION = 48
SECONDS = 15e-6  # of one static contact problem


@dataclass(frozen=True, kw_only=True)
class DesignTask:
    """What is searched.

    objectives, limits : that are minimised, and that must be met
    torques : N m on the pinion, ascending
    seed : of search and deviations
    evaluations : number of candidates at most
    """

    variables: Variables
    objectives: tuple[Quantity, ...]
    limits: tuple[Limit, ...]
    conditions: Conditions
    torques: tuple[float, ...]
    seed: int
    evaluations: int

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Objectives, then quantities of the limits."""
        return tuple(dict.fromkeys([*self.objectives, *(limit.quantity for limit in self.limits)]))

    def judged(self, found: CandidateResults) -> tuple[np.ndarray, np.ndarray]:
        """Objectives (candidate, objective), and relative excess over the limits (candidate, limit), 0 if met."""
        objectives = np.stack([one.of(found) for one in self.objectives], axis=1)
        excess = np.zeros((len(objectives), len(self.limits)))
        for column, limit in zip(excess.T, self.limits, strict=True):
            column[:] = np.maximum(limit.quantity.of(found) - limit.most, 0.0) / (abs(limit.most) or 1.0)
        return objectives, excess


@dataclass(frozen=True, eq=False, kw_only=True)
class Designs:
    """Candidates that were evaluated, and the best of them.

    index : (candidate, variable) numbers of the values
    objectives : (candidate, objective)
    excess : (candidate, limit), relative excess over the limits, 0 if met
    front : candidates that no other one dominates, by the first objective
    """

    task: DesignTask
    index: np.ndarray
    objectives: np.ndarray
    excess: np.ndarray
    front: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        possible = np.flatnonzero((self.excess <= 0.0).all(axis=1) & np.isfinite(self.objectives).all(axis=1))
        values = self.objectives[possible]
        first = np.lexsort((*self.index[possible].T[::-1], *values.T[::-1]))
        kept: list[int] = []
        for at in first:
            if not (values[kept] <= values[at]).all(axis=1).any():
                kept.append(int(at))
        object.__setattr__(self, "front", possible[kept])

    def values(self, candidate: int) -> list[Any]:
        """Values of the variables."""
        return self.task.variables.values(self.index[candidate])


def compromise(values: np.ndarray, unmodified: np.ndarray) -> int | None:
    """The nearest design to the best of all objectives, each over its range, of those that beat the unmodified pair.

    Parameters
    ----------
    values, unmodified : (design, objective) and (objective,); a design must be better in every objective
    """
    distance = np.linalg.norm((values - values.min(axis=0)) / np.maximum(np.ptp(values, axis=0), 1e-300), axis=1)
    distance[~(values < unmodified).all(axis=1)] = np.inf
    at = int(distance.argmin())
    return at if distance[at] < np.inf else None


Candidate = tuple[StagePair, PairModifications]


class Evaluations:
    """Evaluates candidates, each once; results are stored as steps.

    scene : the pair of the scene
    pairs : those of the values of the stage that can be used, by the numbers of these values
    """

    def __init__(
        self, task: DesignTask, scene: StagePair, pairs: Mapping[tuple[int, ...], StagePair], work: Work
    ) -> None:
        self._task, self._work, self.scene, self.pairs = task, replace(work, quiet=True), scene, pairs
        names = {one.name for one in task.quantities}
        self.of_levels = any(one.of_level for one in task.quantities)
        needed = {"laws": True, "roots": "root-stress" in names, "response": self.of_levels}
        self._takes = [name for name, used in needed.items() if used]
        statistics = {one.statistic for one in task.quantities}
        self.conditions = replace(
            task.conditions,
            loaded=tuple(sorted(names & LOADED.keys())),
            samples=task.conditions.samples if statistics != {"nominal"} else (),
        )
        self.known: dict[tuple[int, ...], tuple[np.ndarray, np.ndarray]] = {}

    @staticmethod
    def seconds(conditions: Conditions) -> float:
        """Estimated time of a candidate."""
        return SECONDS * conditions.positions * len(conditions.forces) * (1 + len(conditions.samples))

    @property
    def start(self) -> float:
        """Estimated time of what is computed once for each pair and is not stored; the casing is that of the scene."""
        tasks = {}
        for number, pair in enumerate(self.pairs.values()):
            needed = pair.graph.needed(pair.takes[name] for name in self._takes)
            for task in expected(needed, self._work.cache):
                tasks[task.name if "casing" in task.name else (number, task.name)] = task.seconds
        return sum(tasks.values())

    def results(
        self, candidates: Sequence[Candidate], *, at_scene: bool = False, **conditions: Any
    ) -> CandidateResults:
        """Results of candidates at the torques of the search, or at the load of the scene; `conditions` are changed."""
        groups: dict[StagePair, list[int]] = {}
        for number, (pair, _) in enumerate(candidates):
            groups.setdefault(pair, []).append(number)
        parts = []
        for pair, numbers in groups.items():
            torques = [pair.force * pair.pair.pinion.base_radius] if at_scene else self._task.torques
            forces = tuple(torque / pair.pair.pinion.base_radius for torque in torques)
            own = replace(self.conditions, pair=pair.pair, forces=forces, **conditions)
            step = Step(
                name="candidates",
                kind="candidates",
                build=flank_candidates.build,
                spec={"conditions": own, "candidates": tuple(candidates[number][1] for number in numbers)},
                takes={name: pair.takes[name] for name in self._takes},
                modules=(mesh_response.__name__,) if self.of_levels else (),
                libraries=("numpy", "scipy", "numba"),
                seconds=len(numbers) * self.seconds(own),
            )
            parts.append(self._work.build(Graph([*pair.graph, step]), [step.name]).value(step.name))
        found = CandidateResults.joined(parts, np.argsort(np.concatenate(list(groups.values()))))
        errors = [[100 * abs(pair.pair.ratio / self.scene.pair.ratio - 1)] for pair, _ in candidates]
        ratios = np.broadcast_to(errors, found.peak_to_peak.shape[:2])
        return replace(found, loaded=found.loaded | {RATIO_ERROR: ratios})

    def load_map(self, pair: StagePair, states: Mapping[str, PairModifications]) -> xarray.Dataset:
        """A pair without deviations over the torque, see `pipelines.runs.load_map.load_map`."""
        law, root = pair.takes["laws"], pair.takes["roots"]
        outcome = self._work.build(pair.graph, [law, root])
        laws = {name: modified_law(outcome.value(law)[0], pair.pair, one) for name, one in states.items()}
        sense = self._task.variables.sense
        return load_map(pair.pair, laws, self._task.torques, outcome.value(root), sense=sense)

    def simulated_levels(self, states: Mapping[str, Candidate], work: Work) -> np.ndarray:
        """Levels (state, sensor), m/s2 rms, of pairs without deviations by the time loop, see `level_step`."""
        found = []
        for name, (pair, modifications) in states.items():
            response, simulate = (pair.graph.steps[one] for one in (pair.takes["response"], "simulate"))
            step = mesh_response.level_step(response, simulate, f"motion of {name}", modifications)
            found.append(work.build(Graph([*pair.graph, step]), [step.name]).value(step.name))
        return np.stack(found)

    def candidate(self, index: Sequence[int]) -> Candidate | None:
        """A candidate from the numbers of its values (variable,); None if they give no pair that can be used."""
        variables = self._task.variables
        pair = self.pairs.get(variables.stage_index(index))
        return None if pair is None else (pair, variables.modifications(variables.values(index)))

    def __call__(self, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Objectives (candidate, objective) and excess (candidate, limit) of candidates (candidate, variable)."""
        rows = [tuple(int(at) for at in row) for row in index]
        new = {row: self.candidate(row) for row in dict.fromkeys(rows) if row not in self.known}
        task, possible = self._task, {row: one for row, one in new.items() if one is not None}
        for row in new:
            self.known[row] = np.full(len(task.objectives), np.nan), np.zeros(len(task.limits))
        if possible:
            judged = task.judged(self.results(tuple(possible.values())))
            self.known |= dict(zip(possible, zip(*judged, strict=True), strict=True))
        values = [self.known[row] for row in rows]
        return np.array([one[0] for one in values]), np.array([one[1] for one in values])

    def designs(self) -> Designs:
        """All candidates so far."""
        index = np.array(sorted(self.known))
        objectives, excess = self(index)
        return Designs(task=self._task, index=index, objectives=objectives, excess=excess)


def search(evaluate: Evaluations, task: DesignTask, *, quiet: bool) -> Designs:
    """Evaluate all combinations if there are at most `evaluations`, else search.

    Raises
    ------
    InputError : no candidate meets the limits, or pymoo is not installed
    """
    sizes, fixed = task.variables.sizes, len(task.variables.stage_columns)
    flanks = math.prod(size for n, size in enumerate(sizes) if n not in task.variables.stage_columns)
    total = len(evaluate.pairs) * flanks
    with reported_count("candidates", quiet=quiet) as report:
        most = min(total, task.evaluations)
        words = f"{most} candidates of {len(evaluate.pairs)} gear pairs" if fixed else f"{most} candidates"
        report.line(f"{words}, about {duration(evaluate.start + most * evaluate.seconds(evaluate.conditions))}")
        if total <= task.evaluations:
            every = np.stack(np.unravel_index(np.arange(math.prod(sizes)), sizes), axis=1)
            possible = [row for row in every if task.variables.stage_index(row) in evaluate.pairs]
            possible.sort(key=task.variables.stage_index)
            for start in range(0, total, POPULATION):
                evaluate(np.array(possible[start : start + POPULATION]))
                report(min(start + POPULATION, total), total)
        else:
            _evolve(evaluate, task, lambda: report(len(evaluate.known), task.evaluations))
    found = evaluate.designs()
    if not found.front.size:
        least = ", ".join(
            f"{limit.quantity.label} exceeds {limit.most:g} by {100 * value:.3g} %"
            for limit, value in zip(task.limits, np.nanmin(found.excess, axis=0), strict=True)
            if value > 0
        )
        raise InputError(
            f"design: none of {len(found.index)} candidates meets all limits{f' (at best {least})' if least else ''}. "
            "Increase a limit, or extend the ranges."
        )
    return found


def _evolve(evaluate: Evaluations, task: DesignTask, report: Callable[[], None]) -> None:
    """Half of the evaluations by NSGA-II, then neighbours of the front until all are known."""
    try:
        from pymoo.algorithms.moo.nsga2 import NSGA2
        from pymoo.core.evaluator import Evaluator
        from pymoo.core.problem import Problem
        from pymoo.operators.crossover.sbx import SBX
        from pymoo.operators.mutation.pm import PM
        from pymoo.operators.repair.rounding import RoundingRepair
        from pymoo.operators.sampling.rnd import IntegerRandomSampling
        from pymoo.problems.static import StaticProblem
    except ImportError as error:
        raise InputError(f"design needs pymoo ({error}). Install it with: pip install 'gearcase[design]'") from error
    sizes, most = np.array(task.variables.sizes), task.evaluations
    problem = Problem(
        n_var=sizes.size, n_obj=len(task.objectives), n_ieq_constr=len(task.limits), xl=0, xu=sizes - 1, vtype=int
    )
    algorithm = NSGA2(
        pop_size=POPULATION,
        sampling=IntegerRandomSampling(),
        crossover=SBX(prob=0.9, eta=5, vtype=float, repair=RoundingRepair()),
        mutation=PM(eta=5, vtype=float, repair=RoundingRepair()),
        eliminate_duplicates=True,
    )
    algorithm.setup(problem, termination=("n_gen", max(1, most // POPULATION)), seed=task.seed, verbose=False)
    while algorithm.has_next() and len(evaluate.known) <= most / 2:
        asked = algorithm.ask()
        objectives, excess = evaluate(asked.get("X"))
        values = np.where(np.isfinite(objectives), objectives, 1e30)
        known = {"F": values, "G": np.where(np.isfinite(excess), excess, 1e30)}
        Evaluator().eval(StaticProblem(problem, **known), asked)
        algorithm.tell(infills=asked)
        report()
    steps = np.vstack([np.eye(sizes.size, dtype=int), -np.eye(sizes.size, dtype=int)])
    while len(evaluate.known) < most and (found := evaluate.designs()).front.size:
        near = (found.index[found.front][:, None] + steps).reshape(-1, sizes.size)
        inside = near[((near >= 0) & (near < sizes)).all(axis=1)]
        new = [row for row in dict.fromkeys(map(tuple, inside)) if row not in evaluate.known]
        if not new:
            break
        evaluate(np.array(new[: most - len(evaluate.known)]))
        report()
