"""`gearcase starts`: mean and spread of a motion's levels over several starts, for motions that cannot be repeated."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Run the machine from slightly different states of rest; print what a level is worth."""
    from pipelines.engine.working import Work
    from pipelines.scene.file import changed
    from pipelines.scene.presets import load_asked
    from pipelines.studies.trade.spread import spread_table
    from pipelines.studies.trade.variants import measure

    loaded = load_asked(options)
    scenes = {f"start {n}": changed(loaded, {"simulation.start": n}) for n in range(1, options.starts + 1)}
    found = measure(scenes, ("signals", "lines"), Work(processes=options.processes, quiet=options.quiet))
    sys.stdout.write(spread_table([one.values for one in found.values()]).to_text() + "\n")
    return 0
