"""`gearcase simulate`: the signals of a scene alone."""

from __future__ import annotations

import argparse
import sys

from pipelines.cli.command_line import out_argument, work_arguments

HELP = """\
Simulate the machine and write its signals to response.nc in a result folder, by default under ./runs.
There is no healthy control, no diagnosis and no report. Takes seconds for the scene `minimal`, and up to minutes for
the scenes `rig-...`."""
EXAMPLE = """\
gearcase simulate minimal
signals: runs/minimal/2026-11-25_00-50-21/response.nc"""


def arguments(sub: argparse.ArgumentParser) -> None:
    """A scene, and its result folder."""
    work_arguments(sub)
    out_argument(sub)


def main(options: argparse.Namespace) -> int:
    """Run the machine and write response.nc; no control, diagnosis or report."""
    if not options.quiet:
        from pipelines.io.shown import shown

        sys.stderr.write(f"gearcase simulate {shown(str(options.scene))}\n")  # before the imports, which take a while
    from pipelines.engine.working import Work
    from pipelines.runs.run import Options, run_scene
    from pipelines.runs.run_folder import RESPONSE
    from pipelines.scene.presets import load_asked

    finished = run_scene(
        load_asked(options),
        Options(
            out=options.out,
            with_control=False,
            with_report=False,
            work=Work(processes=options.processes, quiet=options.quiet),
        ),
    )
    sys.stdout.write(f"signals: {finished.folder / RESPONSE}\n")
    return 0
