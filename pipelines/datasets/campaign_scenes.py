"""Scenes of a campaign: the scene of the plan with sampled values, its key, its group and its part of the split."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipelines.datasets.expressions import Expression
from pipelines.datasets.plan import Plan, PlanTable, expressions
from pipelines.datasets.sampling import Values, sampled_values
from pipelines.scene.load_scene import LoadedScene, Source, scene_of_merged
from pipelines.scene.merge import Merged, leaves, merge

SEED_PATH = ("deviations", "seed")
TRAIN, TEST, VALIDATION = "train", "test", "validation"


@dataclass(frozen=True, kw_only=True)
class SampledScene:
    """One scene of a campaign: its number, the values of its variables, its group and its part of the split.

    Variables on which the scene does not depend are None, as the depth of a chip in a healthy scene.
    """

    run: int
    values: Mapping[str, Any]
    group: str
    split: str


def sampled_scenes(plan: Plan) -> list[SampledScene]:
    """All different scenes of a plan, numbered in their order. InputError as in `sampling.sampled_values`."""
    table = plan.table
    distinct: dict[str, dict[str, Any]] = {}
    known: dict[tuple[str, ...], set[str]] = {}  # used variables by the values of the variables that have cases
    for values in sampled_values(plan):
        case = tuple(str(values[name]) for name in table.cases)
        used = known[case] if case in known else known.setdefault(case, used_variables(table, values))
        row = {name: value if name in used else None for name, value in values.items()}
        key = json.dumps(row) if table.design == "grid" else str(len(distinct))  # equal samples may occur by chance
        distinct.setdefault(key, row)
    by = group_variables(table)
    groups = [
        "/".join(f"{name}={row[name]}" for name in by) or str(number) for number, row in enumerate(distinct.values())
    ]
    cases = [tuple(str(row[name]) for name in table.cases) for row in distinct.values()]
    parts = split_groups(table, groups, cases)
    return [
        SampledScene(run=run, values=row, group=group, split=parts[group])
        for run, (row, group) in enumerate(zip(distinct.values(), groups, strict=True))
    ]


def used_variables(table: PlanTable, values: Values) -> set[str]:
    """Variables on which the scene of these values depends."""
    chosen = [table.settings, *(cases[str(values[name])] for name, cases in table.cases.items())]
    texts = [text for tree in chosen for _, text in expressions(tree)]
    return set().union(table.cases.keys(), *(Expression(text[1:]).names for text in texts))


def group_variables(table: PlanTable) -> tuple[str, ...]:
    """Variables whose values keep scenes together in the split; by default those that determine `deviations.seed`.

    Two scenes with the same deviations of the teeth are the same gear pair, which a classifier recognises.
    """
    if table.split.by:
        return table.split.by
    found = [text for path, text in table.references() if path == SEED_PATH]
    names = [name for text in found for name in Expression(text[1:]).names]
    for name, cases in table.cases.items():
        given = [leaves(case).get(SEED_PATH) for case in cases.values()]
        names += [name] * any(seed is not None and not isinstance(seed, str) for seed in given)
    return tuple(dict.fromkeys(names))


def group_words(by: Sequence[str]) -> str:
    """The groups of the split by their variables, in words."""
    alone = "groups of one scene, all with the same pair of gears (deviations.seed is constant)"
    return f"groups of equal {', '.join(by)}" if by else alone


def split_groups(table: PlanTable, groups: Sequence[str], cases: Sequence[tuple[str, ...]]) -> dict[str, str]:
    """Part of the split of each group, stratified by `cases`, on which the labels depend.

    A part gets its share of the groups: one after the other that group which brings its numbers of scenes of all cases
    closest to their share, by the sum of squares. For groups of one scene these are the numbers by largest remainders.
    The seed of the plan chooses between equal groups.

    Parameters
    ----------
    table : seed, and shares of the parts
    groups, cases : of each scene: its group, and the values of the variables that have cases
    """
    distinct, column = sorted(set(groups)), {case: n for n, case in enumerate(sorted(set(cases)))}
    row = {group: n for n, group in enumerate(distinct)}
    counts = np.zeros((len(row), len(column)))
    np.add.at(counts, ([row[group] for group in groups], [column[case] for case in cases]), 1.0)
    kinds, kind = np.unique(counts, axis=0, return_inverse=True)
    left: list[list[str]] = [[] for _ in kinds]
    for place in np.random.default_rng([table.seed, 1]).permutation(len(distinct)):
        left[kind[place]].append(distinct[place])
    parts, remaining = dict.fromkeys(distinct, TRAIN), np.bincount(kind)
    for part, share in ((TEST, table.split.test), (VALIDATION, table.split.validation)):
        lacking = share * counts.sum(axis=0)
        for _ in range(round(share * len(distinct))):
            best = int(np.where(remaining > 0, ((lacking - kinds) ** 2).sum(axis=1), np.inf).argmin())
            parts[left[best].pop()] = part
            lacking, remaining[best] = lacking - kinds[best], remaining[best] - 1
    return parts


def scene_of(plan: Plan, values: Mapping[str, Any]) -> LoadedScene:
    """The scene of sampled values.

    Raises
    ------
    SceneError : the scene of these values is not valid
    ExpressionError : an expression has no value
    """
    merged = merge(Merged(dict(plan.tree)), _filled(plan.table.settings, values))
    for name, cases in plan.table.cases.items():
        merged = merge(merged, _filled(cases[str(values[name])], values))
    return scene_of_merged(plan.name, Source(plan.name, "", None, f"scene of {plan.name}"), {}, merged)


def _filled(tree: Any, values: Mapping[str, Any]) -> Any:
    """A tree with expressions replaced by their values."""
    if isinstance(tree, Mapping):
        return {key: _filled(item, values) for key, item in tree.items()}
    if isinstance(tree, list | tuple):
        return [_filled(item, values) for item in tree]
    if isinstance(tree, str) and tree.startswith("$"):
        return Expression(tree[1:]).value(values)
    return tree


def scene_key(loaded: LoadedScene) -> str:
    """SHA-256 digest of a scene with all defaults, without its name."""
    values = loaded.scene.model_dump(mode="json")
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()
