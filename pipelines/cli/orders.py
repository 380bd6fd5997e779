"""`gearcase orders`: waterfall over speed and order, cuts along orders, natural frequencies over speed."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Write the pictures of a run-up beside its signals, and print the highest amplitude along every order."""
    from pipelines.engine.working import Work
    from pipelines.runs.run_folder import find_run
    from pipelines.runs.run_up import RunUpOptions, write_run_up

    wanted = RunUpOptions(
        shaft=options.shaft, sensor=options.sensor, axis=options.axis, orders=tuple(options.orders),
        revolutions=options.revolutions, campbell=options.campbell, out=options.out,
    )  # fmt: skip
    words, files = write_run_up(find_run(options.run), wanted, Work(quiet=options.quiet))
    sys.stdout.write(words + "\n" + "".join(f"{file}\n" for file in files))
    return 0
