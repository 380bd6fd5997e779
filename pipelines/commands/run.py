"""`gearcase run`: simulation, healthy control, diagnosis and report."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Run the scene; print the verdict and where the report is."""
    from pipelines.engine.working import Work
    from pipelines.runs.run import Options, run_scene
    from pipelines.runs.run_folder import REPORT
    from pipelines.scene.presets import load_asked

    finished = run_scene(
        load_asked(options),
        Options(
            out=options.out,
            with_control=not options.no_control,
            both_loads=not options.one_load,
            seeds=options.seeds,
            baseline=options.baseline,
            work=Work(processes=options.processes, quiet=options.quiet),
        ),
    )
    built = [record for record in finished.records if not record.reused]
    seconds = sum(record.seconds for record in built)
    if finished.words:
        sys.stdout.write(finished.words.partition("\n\n")[0] + "\n")
    for reason in finished.left_out:
        sys.stdout.write(f"{reason}\n")
    sys.stdout.write(
        f"{len(built)} steps built ({seconds:.1f} s of work), {len(finished.records) - len(built)} reused.\n"
        f"report: {finished.folder / REPORT}\n"
    )
    return 0
