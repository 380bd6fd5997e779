"""Scenes of a campaign: the plan's scene with the values of one draw in it, its key, its group and its split."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipelines.datasets.draws import Values, draw
from pipelines.datasets.expressions import Expression
from pipelines.datasets.plan import Plan, PlanTable, expressions
from pipelines.scene.file import LoadedScene, Source, validate
from pipelines.scene.merge import Merged, merge
from pipelines.scene.scene import Scene

SEED_PATH = ("deviations", "seed")
TRAIN, TEST, VALIDATION = "train", "test", "validation"


@dataclass(frozen=True, kw_only=True)
class Draw:
    """One scene of a campaign: its number, the values of its variables, its group and the part it belongs to.

    Variables that nothing in the scene hangs on are None: the depth of a chip that is not there.
    """

    run: int
    values: Mapping[str, Any]
    group: str
    split: str


def make_draws(plan: Plan) -> list[Draw]:
    """All scenes of a plan without repeats, numbered in their order. InputError as `pipelines.datasets.draws.draw`."""
    table = plan.table
    distinct: dict[str, dict[str, Any]] = {}
    known: dict[tuple[str, ...], set[str]] = {}  # by the case of every variable that has cases
    for values in draw(plan):
        case = tuple(str(values[name]) for name in table.cases)
        used = known[case] if case in known else known.setdefault(case, used_variables(table, values))
        row = {name: value if name in used else None for name, value in values.items()}
        key = json.dumps(row) if table.design == "grid" else str(len(distinct))  # samples may meet by chance
        distinct.setdefault(key, row)
    by = group_variables(table)
    groups = ["/".join(f"{name}={row[name]}" for name in by) for row in distinct.values()]
    if not by:
        groups = [str(number) for number in range(len(distinct))]
    parts = split_groups(table, groups)
    return [
        Draw(run=run, values=row, group=group, split=parts[group])
        for run, (row, group) in enumerate(zip(distinct.values(), groups, strict=True))
    ]


def used_variables(table: PlanTable, values: Values) -> set[str]:
    """Variables that the scene of these values hangs on."""
    chosen = [table.settings, *(cases[str(values[name])] for name, cases in table.cases.items())]
    return set().union(table.cases.keys(), *map(_names, chosen))


def _names(tree: Any) -> set[str]:
    """Variables in the expressions of a tree."""
    return {name for _, text in expressions(tree) for name in Expression(text[1:]).names}


def group_variables(table: PlanTable) -> tuple[str, ...]:
    """Variables whose values keep scenes together in the split: by default those that `deviations.seed` hangs on.

    Two scenes with the same deviations of the teeth are the same pair of gears, which a classifier recognises.
    """
    if table.split.by is not None:
        return table.split.by
    found = [text for path, text in table.references() if path == SEED_PATH]
    names = [name for text in found for name in Expression(text[1:]).names]
    return tuple(dict.fromkeys(names))


def split_groups(table: PlanTable, groups: Sequence[str]) -> dict[str, str]:
    """The part of every group, in shares of the groups, drawn by the seed of the plan."""
    distinct = sorted(set(groups))
    order = np.random.default_rng([table.seed, 1]).permutation(len(distinct))
    tests = round(table.split.test * len(distinct))
    validations = round(table.split.validation * len(distinct))
    parts = [TEST] * tests + [VALIDATION] * validations
    parts += [TRAIN] * (len(distinct) - len(parts))
    return {distinct[place]: part for place, part in zip(order, parts, strict=True)}


def scene_of(plan: Plan, values: Mapping[str, Any]) -> LoadedScene:
    """The scene of one draw.

    Raises
    ------
    SceneError : these values make no scene
    ExpressionError : an expression has no value
    """
    merged = merge(Merged(dict(plan.tree)), _filled(plan.table.settings, values))
    for name, cases in plan.table.cases.items():
        merged = merge(merged, _filled(cases[str(values[name])], values))
    source = Source(plan.name, "", None, f"scene of {plan.name}")
    scene, tree = validate(merged, Scene, source.shown)
    return LoadedScene(plan.name, source, {}, tree, scene)


def _filled(tree: Any, values: Mapping[str, Any]) -> Any:
    """A tree with the values of its expressions."""
    if isinstance(tree, Mapping):
        return {key: _filled(item, values) for key, item in tree.items()}
    if isinstance(tree, list | tuple):
        return [_filled(item, values) for item in tree]
    if isinstance(tree, str) and tree.startswith("$"):
        return Expression(tree[1:]).value(values)
    return tree


def scene_key(loaded: LoadedScene) -> str:
    """SHA-256 of a scene with all defaults, whatever it is called."""
    values = loaded.scene.model_dump(mode="json")
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()
