"""`gearcase run`: simulation, healthy control, diagnosis and report."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

from pipelines.cli.command_line import RUN_FOLDER, WORK, announce, argument, scene_and_work
from pipelines.io.argument_types import count

ARGUMENTS = (
    *WORK,
    RUN_FOLDER,
    argument(
        "--no-control",
        action="store_true",
        help="do not simulate the healthy control; there is no diagnosis without it",
    ),
    argument(
        "--one-load",
        action="store_true",
        help="simulate the load of the scene only (default: also a constant torque in place of a suspended load)",
    ),
    argument(
        "--seeds",
        metavar="N",
        type=count,
        default=0,
        help="also simulate the scene and its control with the deviations of each seed from 1 to N, and without "
        "deviations (default: only with the seed of the scene)",
    ),
    argument(
        "--baseline",
        metavar="N",
        type=count,
        default=0,
        help="compare the machine with N healthy ones, which have other deviations; limits need 5 or more (default 0)",
    ),
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Simulate the machine and its healthy control, diagnose the fault from the signals and write a report. The result
    folder holds report.html, response.nc (the signals), the diagnosis and the settings. Takes seconds for the scenes
    `minimal` and `bench`, and less than a minute for `rig-missing-tooth`. The first run after installation also
    compiles code, which takes 20 seconds more. Results of earlier runs are reused from the cache.

    Example
    -------
    gearcase run bench
    Chipped tooth 10 of the stage 1 wheel: found. Evidence (steady, torque load, deviations of seed 1): ...
    ...
    report: runs/bench/2026-11-25_01-02-13/report.html
    ...
    """
    announce(options)
    from pipelines.runs.run import run_scene
    from pipelines.runs.run_folder import REPORT

    loaded, work = scene_and_work(options)
    finished = run_scene(
        loaded,
        out=options.out,
        with_control=not options.no_control,
        both_loads=not options.one_load,
        seeds=options.seeds,
        baseline=options.baseline,
        work=work,
    )
    built = [record for record in finished.records if not record.reused]
    seconds = sum(record.seconds for record in built)
    if finished.words:
        yield finished.words.partition("\n\n")[0]
    yield from finished.left_out
    yield (
        f"{len(built)} steps computed, {seconds:.1f} s in sum; {len(finished.records) - len(built)} reused from "
        "the cache.\n"
        f"report: {finished.folder / REPORT}\n"
        "next:"
    )
    yield from (f"  {command}\n      {what}" for command, what in _next(options))


def _next(options: argparse.Namespace) -> Iterator[tuple[str, str]]:
    """Two commands that follow a first run, and what they do; as this one was typed where PATH does not hold it."""
    import shlex
    import shutil

    from pipelines.io.shown_text import shown

    typed = sys.argv[0]
    program = shlex.quote(typed) if Path(typed).name == "gearcase" and not shutil.which("gearcase") else "gearcase"
    scene = shown(shlex.quote(str(options.scene)))
    run = shown(shlex.quote(str(options.out or options.scene)))
    yield f"{program} runs open {run}", "open the report in a browser"
    if str(options.scene).endswith(".toml") or Path("my.toml").exists():
        yield f"{program} inspect {scene}", "write pictures of its gears in mesh"
    else:
        yield f"{program} new my.toml --from {scene}", "write a commented copy of the scene to change"
