"""`gearcase features`: the features of recordings, runs or a data set as a table."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path

from pipelines.cli.command_line import MACHINE, NOISE, QUIET, START, argument
from pipelines.io.argument_types import count, from_zero, path

ARGUMENTS = (
    argument(
        "sources",
        metavar="PATH",
        type=path,
        nargs="+",
        help="recording, folder of recordings, run (also with a window, as in bench@0.5:2.5), or folder of a data set",
    ),
    MACHINE,
    START,
    argument(
        "--end",
        type=from_zero,
        metavar="T",
        default=math.inf,
        help="ignore the signals after this time, s (default: their end)",
    ),
    NOISE,
    argument("--out", metavar="FILE", type=path, help="file to write, which ends in .parquet or .csv"),
    argument(
        "--processes", type=count, metavar="N", help="signals processed at the same time (default: number of cores)"
    ),
    QUIET,
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Compute the features of recordings, finished runs or a data set: a row for each channel, component and feature,
    with value, unit and level. Names and definitions are the same for all. Without --out the table is printed as CSV;
    that of a data set is written to features.parquet in its folder. Takes seconds, for a data set minutes.

    Example
    -------
    gearcase features bench
    recording,sensor,axis,component,feature,unit,value,level_dB
    ...
    bench,motor_side,x,stage 1 pinion,fm4,1,...
    ...
    """
    from pipelines.datasets.feature_source import ENDINGS, FEATURES, FeatureSource, write_features
    from pipelines.datasets.workers import local_workers
    from pipelines.engine.progress import reported_count
    from pipelines.io.user_files import writable_file

    found = FeatureSource(options.sources, options.machine, options.start, options.end, options.noise)
    kept = found.folder / FEATURES if found.folder else None
    target = writable_file(options.out, endings=ENDINGS) if options.out else kept
    with local_workers(options.processes) as workers, reported_count("signals", quiet=options.quiet) as report:
        frames = found.frames(workers.executor, report)
        if target is not None:
            yield f"{target}: {write_features(Path(target), frames)} rows"
        else:
            for number, frame in enumerate(frames):
                yield frame.to_csv(index=False, header=not number, float_format="%.9g", lineterminator="\n")
