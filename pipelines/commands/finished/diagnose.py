"""`gearcase diagnose`: the lines of a fault in a finished run, looked for anew."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Print verdict and envelope tables; --set diagnosis.... looks elsewhere without running anything."""
    from pipelines.runs.diagnosed import diagnose_folder
    from pipelines.runs.run_folder import find_run
    from pipelines.steps.diagnosing import words

    found = diagnose_folder(find_run(options.run), options.settings)
    sys.stdout.write(words([found], [found]))
    return 0
