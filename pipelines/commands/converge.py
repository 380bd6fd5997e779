"""`gearcase converge`: does the answer still change when one thing is refined?"""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Refine along one axis; print order, limit, error band and a verdict; write the plot."""
    from pipelines.border.user_files import writable_file
    from pipelines.engine.cache import Cache
    from pipelines.engine.progress import shown_progress
    from pipelines.scene.presets import load_asked
    from pipelines.trade.refinement import refine
    from pipelines.trade.refinement_page import convergence_figure, convergence_table, verdict

    loaded = load_asked(options)
    path = writable_file(options.out or f"convergence-{loaded.name}-{options.over}.png")
    with shown_progress(0, quiet=options.quiet) as observer:
        found = refine(loaded, options.over, options.levels, Cache(), observer=observer, processes=options.processes)
    sys.stdout.write(convergence_table(loaded.name, found).to_text() + "\n")
    sys.stdout.write(verdict(found, options.error) + "\n")
    path.parent.mkdir(parents=True, exist_ok=True)
    convergence_figure(loaded.name, found).savefig(path, dpi=130)
    sys.stdout.write(f"plot: {path}\n")
    return 0
