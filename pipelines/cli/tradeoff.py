"""`gearcase tradeoff`: the price of every model and main setting, on this machine and this scene."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Measure every choice against the reference; print the table and the answers, write the plot."""
    from pipelines.engine.working import Work
    from pipelines.io.user_files import writable_file
    from pipelines.report.figures.film import save_figure
    from pipelines.scene.presets import load_asked
    from pipelines.studies.trade.tradeoff import trade
    from pipelines.studies.trade.tradeoff_page import answers, trade_figure, trade_table

    loaded = load_asked(options)
    path = writable_file(options.out or f"tradeoff-{loaded.name}.png")
    found = trade(loaded, Work(processes=options.processes, quiet=options.quiet))
    sys.stdout.write(trade_table(found).to_text() + "\n")
    sys.stdout.write("".join(f"{line}\n" for line in answers(found, options.error, options.time)))
    save_figure(trade_figure(found), path, dpi=130)
    sys.stdout.write(f"plot: {path}\n")
    return 0
