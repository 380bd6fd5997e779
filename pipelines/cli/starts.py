"""`gearcase starts`: mean and spread of a motion's levels over several starts, for motions that cannot be repeated."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pipelines.cli.command_line import WORK, argument, scene_and_work
from pipelines.io.argument_types import several

ARGUMENTS = (
    *WORK,
    argument("--starts", type=several, metavar="N", default=8, help="number of initial states, 2 or more (default 8)"),
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Simulate a scene from several slightly different initial states. Print mean and spread of the level of each
    sensor. Use it where teeth lose contact, so that levels depend on the initial state. Takes one simulation for each
    start.

    Example
    -------
    gearcase starts minimal --set load.container_kg=2
    8 initial states
    level                         mean  mean +/- (95 % interval)  standard deviation  lowest  highest
    ...
    sensor_3 rms, lifting, m/s2  0.798                  0.009512             0.01138  0.7769   0.8056
    """
    from pipelines.scene.load_scene import changed
    from pipelines.studies.trade.measured_variants import measure
    from pipelines.studies.trade.starts_table import spread_table

    loaded, work = scene_and_work(options)
    scenes = {f"start {n}": changed(loaded, {"simulation.start": n}) for n in range(1, options.starts + 1)}
    found = measure(scenes, ("signals", "lines"), work)
    yield spread_table([one.values for one in found.values()]).to_text()
