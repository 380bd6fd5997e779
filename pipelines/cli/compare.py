"""`gearcase compare`: recordings side by side, measured or simulated."""

from __future__ import annotations

import argparse
import sys

from pipelines.io.argument_types import count, path

HELP = """\
Compare recordings, measured or simulated. Print a table of features; write it as CSV, and figures of order spectra,
envelope spectra and time-synchronous averages. The first recording is the reference. Takes seconds."""
EXAMPLE = """\
gearcase compare bench@0.5:0.9 bench@0.9:1.3
   recording               s  turns   rpm  f_m Hz  samples/s  speed from
-  -------------  ----------  -----  ----  ------  ---------  -------------------------
A  bench@0.5:0.9  0.5 to 0.9   10.0  1500     625      12800  recorded angle of shaft_1
B  bench@0.9:1.3  0.9 to 1.3   10.0  1500     625      12800  recorded angle of shaft_1
...
comparison/features.csv"""


def arguments(sub: argparse.ArgumentParser) -> None:
    """Recordings, and what of them is shown."""
    sub.add_argument(
        "recordings",
        metavar="RECORD",
        type=path,
        nargs="+",
        help="2 to 10 recording files, or runs by folder, scene name or number; add a time window by its name or in s, "
        "as in bench@steady or bench@0.5:2.5",
    )
    sub.add_argument(
        "--machine",
        metavar="FILE",
        type=path,
        help="machine of the recordings: a file with teeth, speed and sensors, or a scene",
    )
    sub.add_argument("--sensor", metavar="NAME", help="sensor in the figures (default: that with the highest level)")
    sub.add_argument(
        "--axis", choices=("x", "y", "z"), help="axis of the sensor (default: that with the highest level)"
    )
    sub.add_argument(
        "--shaft",
        metavar="N",
        type=count,
        help="number of the shaft of the time-synchronous averages (default: that whose features differ most)",
    )
    sub.add_argument("--out", metavar="FOLDER", type=path, help="folder for figures and CSV (default: ./comparison)")


def main(options: argparse.Namespace) -> int:
    """Print the speeds and the table of features; write that as CSV, and the figures."""
    from pipelines.runs.compared import CompareOptions, compare_files

    wanted = CompareOptions(
        machine=options.machine, sensor=options.sensor, axis=options.axis, shaft=options.shaft, out=options.out
    )
    words, files = compare_files(options.recordings, wanted)
    sys.stdout.write(words + "\n" + "".join(f"{file}\n" for file in files))
    return 0
