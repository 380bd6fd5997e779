"""`gearcase explain`: what a run would build and reuse, and why."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pipelines.cli.command_line import SCENE

ARGUMENTS = (*SCENE,)


_WORDS = {"reuse": "reuse", "build": "compute", "follow": "perhaps"}


def main(options: argparse.Namespace) -> Iterator[str]:
    """Print which steps of a run would be reused from the cache, which would be computed, and which changed setting is
    the reason. Nothing is computed and no file is written. Takes seconds.

    Example
    -------
    gearcase explain bench
    First run: the cache holds no results of a similar scene to compare with.
    ...
    compute  law_1
    ...
    """
    from pipelines.engine.cache import Cache
    from pipelines.engine.step import explain
    from pipelines.scene.presets import load_requested
    from pipelines.steps.run_plan import plan_run

    graph = plan_run(load_requested(options)).graph
    found = explain(graph, Cache())
    ends = graph.steps.keys() - {name for step in graph for name in step.inputs}
    first = all(status.first for status in found if status.name in ends)
    if first:
        yield "First run: the cache holds no results of a similar scene to compare with."
    width = max(len(status.name) for status in found)
    for status in found:
        reason = "" if first and status.action != "reuse" else status.reason
        yield f"{_WORDS[status.action]:8} {status.name:{width}}  {reason}".rstrip()
    actions = [status.action for status in found]
    yield (
        f"{actions.count('build')} steps to compute, {actions.count('reuse')} to reuse, "
        f"{actions.count('follow')} undecided (reused if the new input turns out to be unchanged). "
        "Diagnosis and report follow and take seconds."
    )
