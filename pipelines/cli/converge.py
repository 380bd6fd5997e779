"""`gearcase converge`: a convergence study along one axis."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Refine along one axis; print order, limit, error band and a verdict; write the plot."""
    from pipelines.engine.working import Work
    from pipelines.io.user_files import writable_file
    from pipelines.report.figures.film import save_figure
    from pipelines.scene.presets import load_asked
    from pipelines.studies.trade.known_lines import known_lines
    from pipelines.studies.trade.refinement import refine
    from pipelines.studies.trade.refinement_page import (
        convergence_figure,
        convergence_table,
        not_refined,
        pairing_words,
        verdict,
    )
    from pipelines.studies.trade.slicing import slicing_table

    loaded = load_asked(options)
    path = writable_file(options.out or f"convergence-{loaded.name}-{options.over}.png")
    work = Work(processes=options.processes, quiet=options.quiet)
    found = refine(loaded, options.over, options.levels, work)
    sys.stdout.write(convergence_table(loaded.name, found).to_text() + "\n")
    if options.over == "slices":
        sys.stdout.write(slicing_table(loaded.name, found).to_text() + "\n")
    models = [stage.mesh.model for stage in loaded.scene.stages]
    left = not_refined(models, loaded.scene.casing.model, options.over)
    said = (pairing_words(found), verdict(found, options.error), left)
    sys.stdout.write("".join(f"{text}\n" for text in said if text))
    if options.over == "casing-mesh" and (known := known_lines(loaded, work)):
        sys.stdout.write(f"{known}\n")
    save_figure(convergence_figure(loaded.name, found), path, dpi=130)
    sys.stdout.write(f"plot: {path}\n")
    return 0
