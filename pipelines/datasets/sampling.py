"""Sampled values of all variables in every scene of a plan, from its design and seed.

A sampled design fills the unit cube, with one axis for each variable in the order of the plan. The inverse of the
distribution of a variable turns shares on its axis into values. Points that a constraint excludes are skipped.

References
----------
Sobol' (1967), USSR Comput. Math. Math. Phys. 7(4), 86-112, scrambled after Owen (1998); McKay, Beckman & Conover
(1979), Technometrics 21(2), 239-245 (Latin hypercube); both as in scipy.stats.qmc.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from pipelines.datasets.expressions import Expression, ExpressionError
from pipelines.datasets.plan import MOST_SCENES, Plan, PlanTable
from pipelines.datasets.variables import Level
from pipelines.io.errors import InputError

LEAST_SHARE = 1e-3  # of the points must satisfy the constraints
_BATCH = 1024

Values = dict[str, Level]


def sampled_values(plan: Plan) -> list[Values]:
    """The values of the variables in every scene, in the order of the campaign.

    Raises
    ------
    InputError : a constraint has no value or excludes nearly all points, or a grid is too large
    """
    table = plan.table
    constraints = [Expression(text) for text in table.constraints]
    points = _grid(table) if table.design == "grid" else _sampled(table)
    count = MOST_SCENES if table.scenes is None else table.scenes
    found: list[Values] = []
    for tried, values in enumerate(points, 1):
        if _allowed(constraints, values):
            found.append(values)
        if len(found) == count:
            return found
        if tried > _BATCH / LEAST_SHARE and len(found) < LEAST_SHARE * tried:
            raise InputError(
                f"constraints: {len(found)} of {tried} samples satisfy them, at least {100 * LEAST_SHARE:g} % "
                "must. Narrow the ranges of the variables instead."
            )
    if not found:
        raise InputError("constraints: no point of the grid satisfies them. Correct the constraints or the values.")
    return found


def _allowed(constraints: list[Expression], values: Values) -> bool:
    try:
        return all(constraint.value(values) for constraint in constraints)
    except ExpressionError as error:
        raise InputError(f"constraints: {error}. Correct it.") from error


def _grid(table: PlanTable) -> Iterator[Values]:
    axes = {name: variable.grid() for name, variable in table.variables.items()}
    count = math.prod(map(len, axes.values()))
    if count > MOST_SCENES:
        raise InputError(f"variables: their grid has {count} points, limit {MOST_SCENES}. Reduce levels or the lists.")
    for point in itertools.product(*axes.values()):
        yield dict(zip(axes, point, strict=True))


def _sampled(table: PlanTable) -> Iterator[Values]:
    """Points of the design, without end."""
    variables = table.variables
    if not variables:
        yield from ({} for _ in itertools.count())
    for cube in _cubes(table.design, len(variables), table):
        columns = [variable.at(shares) for variable, shares in zip(variables.values(), cube.T, strict=True)]
        for point in zip(*columns, strict=True):
            yield dict(zip(variables, point, strict=True))


def _cubes(design: str, axes: int, table: PlanTable) -> Iterator[np.ndarray]:
    """Batches of the design: shares (point, axis) from 0 to below 1."""
    from scipy.stats import qmc

    random = np.random.default_rng(table.seed)
    if design == "random":
        while True:
            yield random.random((_BATCH, axes))
    sampler: Any
    if design == "sobol":
        sampler = qmc.Sobol(axes, seed=random)
        while True:
            yield sampler.random_base2(10) if sampler.num_generated == 0 else sampler.random(_BATCH)
    assert table.scenes is not None
    while True:
        sampler = qmc.LatinHypercube(axes, seed=random)
        yield sampler.random(table.scenes)
