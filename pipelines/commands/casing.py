"""`gearcase casing`: the reduced casing of a scene and its check-up."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Build the casing; print the check-up (elastic rungs) or the coordinates (the others)."""
    from pipelines.build import run_graph
    from pipelines.cache import Cache
    from pipelines.study import plan_study
    from pipelines.terminal import shown_progress
    from pipelines.trade.presets import load_asked

    loaded = load_asked(options)
    graph = plan_study(loaded, with_control=False, both_loads=False).graph
    with shown_progress(len(graph.needed(["casing"]).stages), quiet=options.quiet) as observer:
        outcome = run_graph(graph, Cache(), ["casing"], observer=observer, processes=options.processes)
    body = outcome.value("casing")
    if "casing modes" in graph.stages:
        modes, check = outcome.value("casing modes")
        sys.stdout.write(f"{modes.unknowns} unknowns, solver {modes.solver}\n{check.report()}\n")
    sys.stdout.write(f"casing {body.model}: {len(body.coordinate_names)} coordinates, {len(body.row_names)} rows\n")
    for name, (x, y, z) in zip(body.point_names, body.point_positions * 1000, strict=True):
        sys.stdout.write(f"  {name:10} x {x:8.2f}  y {y:8.2f}  z {z:8.2f} mm\n")
    return 0
