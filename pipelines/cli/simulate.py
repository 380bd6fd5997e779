"""`gearcase simulate`: the signals of a scene alone."""

from __future__ import annotations

import argparse
import sys


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
