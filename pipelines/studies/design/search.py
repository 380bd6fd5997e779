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
from pipelines.engine.run_graph import Work
from pipelines.engine.step import Graph, Step
from pipelines.io.errors import InputError
from pipelines.io.shown_text import duration
from pipelines.runs.load_map import load_map
from pipelines.steps import flank_candidates
from pipelines.steps.flank_candidates import LOADED, CandidateResults, Conditions
from pipelines.steps.mesh_response import level_step
from pipelines.studies.design.flank_variables import Variables
from pipelines.studies.design.quantities import Limit, Quantity

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

    @property
    def compromise(self) -> int:
        """The candidate of the front with the least distance from the best of all objectives, each over its range."""
        values = self.objectives[self.front]
        span = np.maximum(np.ptp(values, axis=0), 1e-300)
        return int(self.front[np.linalg.norm((values - values.min(axis=0)) / span, axis=1).argmin()])

    def values(self, candidate: int) -> list[Any]:
        """Values of the variables."""
        return self.task.variables.values(self.index[candidate])


class Evaluations:
    """Evaluates candidates, each once; results are stored as steps."""

    def __init__(self, task: DesignTask, graph: Graph, law: str, root: Step, response: Step | None, work: Work) -> None:
        self._task, self._work = task, replace(work, quiet=True)
        names = {one.name for one in task.quantities} & LOADED.keys()
        self._takes, self._graph, self._root = {"laws": law}, [*graph, root], root.name
        self._modules: tuple[str, ...] = ()
        self._response = response
        self.start = 0.0  # seconds before the first candidate
        if "root-stress" in names:
            self._takes["roots"], self.start = root.name, root.seconds
        if response is not None:
            self._graph.append(response)
            self._takes["response"], self._modules = response.name, (response.build.__module__,)
        statistics = {one.statistic for one in task.quantities}
        self.conditions = replace(
            task.conditions,
            loaded=tuple(sorted(names)),
            samples=task.conditions.samples if statistics != {"nominal"} else (),
        )
        self.known: dict[tuple[int, ...], tuple[np.ndarray, np.ndarray]] = {}

    @staticmethod
    def seconds(conditions: Conditions) -> float:
        """Estimated time of a candidate."""
        return SECONDS * conditions.positions * len(conditions.forces) * (1 + len(conditions.samples))

    def results(self, found: Sequence[PairModifications], conditions: Conditions) -> CandidateResults:
        """Results of modifications."""
        step = Step(
            name="candidates",
            kind="candidates",
            build=flank_candidates.build,
            spec={"conditions": conditions, "candidates": tuple(found)},
            takes=self._takes,
            modules=self._modules,
            libraries=("numpy", "scipy", "numba"),
            seconds=len(found) * self.seconds(conditions),
        )
        return self._work.build(Graph([*self._graph, step]), ["candidates"]).value("candidates")

    def load_map(self, states: Mapping[str, PairModifications], sense: int) -> xarray.Dataset:
        """The pair without deviations over the torque; `sense` as in `pipelines.runs.load_map.load_map`."""
        law, pair = self._takes["laws"], self._task.conditions.pair
        outcome = self._work.build(Graph(self._graph), [law, self._root])
        laws = {name: modified_law(outcome.value(law)[0], pair, one) for name, one in states.items()}
        return load_map(pair, laws, self._task.torques, outcome.value(self._root), sense=sense)

    def simulated_levels(self, states: Mapping[str, PairModifications], work: Work) -> np.ndarray:
        """Levels (state, sensor), m/s2 rms, of the pair without deviations by the time loop, see `level_step`."""
        assert self._response is not None  # a quantity is a level
        simulate = Graph(self._graph).steps["simulate"]
        steps = [level_step(self._response, simulate, f"motion of {name}", one) for name, one in states.items()]
        outcome = work.build(Graph([*self._graph, *steps]), [one.name for one in steps])
        return np.stack([outcome.value(one.name) for one in steps])

    def __call__(self, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Objectives (candidate, objective) and excess (candidate, limit) of candidates (candidate, variable)."""
        rows = [tuple(int(at) for at in row) for row in index]
        new = [row for row in dict.fromkeys(rows) if row not in self.known]
        if new:
            variables, task = self._task.variables, self._task
            found = self.results([variables.modifications(variables.values(row)) for row in new], self.conditions)
            objectives = np.stack([one.of(found) for one in task.objectives], axis=1)
            excess = np.zeros((len(new), len(task.limits)))
            for column, limit in zip(excess.T, task.limits, strict=True):
                column[:] = np.maximum(limit.quantity.of(found) - limit.most, 0.0) / (abs(limit.most) or 1.0)
            self.known |= {row: pair for row, *pair in zip(new, objectives, excess, strict=True)}  # type: ignore[misc]
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
    sizes = task.variables.sizes
    total = math.prod(sizes)
    with reported_count("candidates", quiet=quiet) as report:
        most = min(total, task.evaluations)
        report.line(
            f"{most} candidates, about {duration(evaluate.start + most * evaluate.seconds(evaluate.conditions))}"
        )
        if total <= task.evaluations:
            every = np.stack(np.unravel_index(np.arange(total), sizes), axis=1)
            for start in range(0, total, POPULATION):
                evaluate(every[start : start + POPULATION])
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
