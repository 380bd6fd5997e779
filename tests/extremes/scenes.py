"""Scenes for the extremes: mutations of shipped ones, and the run of a valid one: finite, energy balance closed."""

from __future__ import annotations

import copy
import random
import string
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipelines.engine.cache import Cache
from pipelines.engine.run_graph import run_graph
from pipelines.scene.load_scene import LoadedScene, find_source, read_tree
from pipelines.steps.run_plan import plan_run

EXTREMES = (
    *(0, -1, 1, 1e-300, 1e-12, -1e-12, 1e-3, 1e3, 1e6, 1e12, 1e300, -1e300),
    *(2**31, 2**63, 0.5, 1.5, float("inf"), float("nan")),
)
WRONG_TYPES = (True, False, "", "0", "rigid", "none", "ä", "\x00", "x" * 3000, [], {}, [1], [[1]], {"a": 1}, ["a", 1])


def shipped_tree(name: str) -> dict[str, Any]:
    """The tree of a shipped scene, `extends` merged."""
    return copy.deepcopy(read_tree(find_source(name)).tree)


def places(tree: Any, path: tuple = ()) -> Iterator[tuple]:
    """Paths of every value below the tree, tables and arrays themselves too."""
    items = tree.items() if isinstance(tree, Mapping) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in items:
        yield (*path, key)
        yield from places(value, (*path, key))


def at(tree: Any, path: tuple) -> Any:
    """The value at a path."""
    for key in path:
        tree = tree[key]
    return tree


def mutated(tree: dict[str, Any], draw: random.Random) -> tuple[dict[str, Any], str]:
    """A copy with one to three things changed, and what they were."""
    tree, done = copy.deepcopy(tree), []
    for _ in range(draw.choice((1, 1, 2, 3))):
        path = draw.choice(list(places(tree)))
        parent, key = at(tree, path[:-1]), path[-1]
        how = draw.choice(("extreme", "near", "near", "near", "near", "type", "drop", "typo", "copy"))
        done.append(f"{how} {'.'.join(map(str, path))}")
        if how == "extreme":
            parent[key] = draw.choice(EXTREMES)
        elif how == "near" and isinstance(parent[key], int | float) and not isinstance(parent[key], bool):
            parent[key] = type(parent[key])(parent[key] * draw.choice((-1, 0.01, 0.1, 0.5, 0.9, 1.1, 2, 10, 100)))
        elif how == "drop":
            del parent[key]
        elif how == "typo" and isinstance(parent, dict):
            letters = list(str(key))
            letters[draw.randrange(len(letters))] = draw.choice(string.ascii_letters + "_ .é")
            parent["".join(letters)] = parent.pop(key)
        elif how == "copy":
            parent[key] = copy.deepcopy(at(tree, draw.choice(list(places(tree)))))
        else:
            parent[key] = copy.deepcopy(draw.choice(WRONG_TYPES))
    return tree, ", ".join(done)


def simulated(loaded: LoadedScene, cache: Path) -> Any:
    """The trajectory of a scene."""
    graph = plan_run(loaded, with_control=False, both_loads=False).graph
    return run_graph(graph, Cache(cache), ["simulate"], processes=1).value("simulate")


def unexplained(trajectory: Any) -> list[str]:
    """What is not finite, and energy balances that do not close; empty for a good run."""
    finite = np.isfinite(trajectory.values).all()
    return [*(() if finite else ["a channel is not finite"]), *trajectory.unbalanced()]
