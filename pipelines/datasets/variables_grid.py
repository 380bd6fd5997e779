"""Printed table of the variables of a data set: distribution, keys of the scene that they set, values of the runs."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from pipelines.datasets.plan import expressions
from pipelines.io.text_table import Grid, grid

_DESIGNS = {
    "grid": "every point of a grid",
    "random": "independent random samples",
    "latin-hypercube": "Latin hypercube",
    "sobol": "Sobol points, scrambled after Owen",
}
_MOST_VALUES = 8  # upper bound of the values of a list that are shown


def varied_grid(plan: Mapping[str, Any], columns: Mapping[str, np.ndarray]) -> Grid:
    """Variables with their distribution, keys, and range in the runs that have a row.

    Parameters
    ----------
    plan : that of campaign.json
    columns : see `pipelines.datasets.columns.read_columns`
    """
    return grid(
        "",
        (
            {
                "variable": name,
                "distribution": distribution(variable),
                "sets": ", ".join(_several(sets(plan, name))),
                "in the rows": observed(columns.get(name, np.array([]))),
            }
            for name, variable in plan["variables"].items()
        ),
    )


def sets(plan: Mapping[str, Any], variable: str) -> list[str]:
    """Keys of the scene that depend on a variable, and so define its unit; items of a list have the key of the list."""
    name = re.compile(rf"\b{variable}\b")
    cases = [case for values in plan["cases"].values() for case in values.values()]
    trees = (plan["settings"], *cases)
    found = [
        re.sub(r"(\.\d+)+$", "", ".".join(path))
        for tree in trees
        for path, text in expressions(tree)
        if name.search(text)
    ]
    return list(dict.fromkeys(found + [f"cases.{variable}"] * (variable in plan["cases"])))


def _several(keys: list[str]) -> list[str]:
    """Several keys with "*" in place of the number of an item, each once; a single one as it is."""
    return keys if len(keys) == 1 else list(dict.fromkeys(re.sub(r"\.\d+\b", ".*", key) for key in keys))


def design_words(plan: Mapping[str, Any]) -> str:
    """Design of the samples, and its seed."""
    words = _DESIGNS[plan["design"]]
    seed = "" if plan["design"] == "grid" else f", seed {plan['seed']}"
    limits = f"; only where {' and '.join(plan['constraints'])}" if plan["constraints"] else ""
    return f"{words}{seed}{limits}"


def distribution(variable: Mapping[str, Any]) -> str:
    """The distribution of a variable of the plan in words."""
    low, high = variable.get("from"), variable.get("to")
    if "distribution" in variable:
        given = ", ".join(f"{name} {value:g}" for name, value in variable["parameters"].items())
        limits = [f"{word} {limit:g}" for word, limit in (("from", low), ("to", high)) if limit is not None]
        cut = f", only {' '.join(limits)}" if limits else ""
        return f"{variable['distribution']} of scipy.stats ({given}){cut}"
    if "values" in variable:
        return _list_words(variable["values"], variable["weights"])
    kind = "whole numbers" if isinstance(low, int) and isinstance(high, int) else "uniform"
    levels = f", {variable['levels']} levels" if variable.get("levels") else ""
    return f"{kind} from {low:g} to {high:g}{levels}"


def _list_words(values: list[Any], weights: list[float] | None) -> str:
    shown = [str(value) for value in values]
    if weights is not None:
        shown = [f"{text} ({100 * weight / sum(weights):.3g} %)" for text, weight in zip(shown, weights, strict=True)]
    left = len(shown) - _MOST_VALUES
    return f"one of {', '.join(shown[:_MOST_VALUES])}{f' and {left} more' if left > 0 else ''}"


def observed(values: np.ndarray) -> str:
    """Range of numbers, or frequency of each text; runs without a value are omitted."""
    if values.dtype.kind in "fi":
        found = values[np.isfinite(values)]
        return f"{found.min():.6g} to {found.max():.6g}" if found.size else "none yet"
    names, counts = np.unique([str(value) for value in values if value], return_counts=True)
    shown = [f"{name} {count}" for name, count in zip(names, counts, strict=True)]
    return ", ".join(shown[:_MOST_VALUES]) or "none yet"
