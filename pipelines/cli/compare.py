"""`gearcase compare`: recordings side by side, measured or simulated."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Print the speeds and the table of features; write that as CSV, and the figures."""
    from pipelines.runs.compared import CompareOptions, compare_files

    wanted = CompareOptions(
        machine=options.machine, sensor=options.sensor, axis=options.axis, shaft=options.shaft, out=options.out
    )
    words, files = compare_files(options.recordings, wanted)
    sys.stdout.write(words + "\n" + "".join(f"{file}\n" for file in files))
    return 0
