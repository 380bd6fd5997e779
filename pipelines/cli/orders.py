"""`gearcase orders`: waterfall over speed and order, cuts along orders, natural frequencies over speed."""

from __future__ import annotations

import argparse
import sys

from pipelines.cli.command_line import quiet_argument, run_argument
from pipelines.io.argument_types import count, path, positive, several

HELP = """\
Analyse the run-up or coast-down of a finished run by orders of a shaft. Print the highest amplitude of each order.
Write pictures of the order spectra over speed, and of the amplitude of each order over speed. Takes seconds."""
EXAMPLE = """\
gearcase orders reducer
input-bearing z over the orders of shaft 1, 11 windows
  order  highest m/s2  at rpm   at Hz
-------  ------------  ------  ------
...
     46        0.0944    1470  1126.7
runs/reducer/2026-11-25_01-02-30/orders.png
..."""


def arguments(sub: argparse.ArgumentParser) -> None:
    """A run and the orders that are shown."""
    run_argument(sub)
    sub.add_argument(
        "--shaft",
        metavar="N",
        type=count,
        help="number of the shaft whose speed is order 1 (default: the driven shaft)",
    )
    sub.add_argument(
        "--sensor", metavar="NAME", help="sensor to analyse (default: that of the diagnosis, or the first)"
    )
    sub.add_argument("--axis", choices=("x", "y", "z"), help="axis of the sensor (default: that of the diagnosis)")
    sub.add_argument(
        "--orders",
        metavar="K",
        type=positive,
        nargs="+",
        default=[],
        help="orders whose amplitudes are shown over speed (default: the mesh orders)",
    )
    sub.add_argument(
        "--revolutions", metavar="N", type=several, default=16, help="revolutions in a window, 2 or more (default 16)"
    )
    sub.add_argument("--campbell", action="store_true", help="add a Campbell diagram: natural frequencies over speed")
    sub.add_argument("--out", metavar="FOLDER", type=path, help="folder for the pictures (default: the result folder)")
    quiet_argument(sub)


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
