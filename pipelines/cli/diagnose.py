"""`gearcase diagnose`: what is damaged in a recording, or the lines of a fault in a finished run, looked for anew."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Print verdict and tables: of a file, or of a run against its control; nothing is simulated."""
    from pipelines.io.errors import InputError
    from pipelines.io.json_text import json_text
    from pipelines.runs.recorded import file_facts, file_words, judge_file, recording_path
    from pipelines.runs.run_folder import RESPONSE

    path = recording_path(options.run)
    measured = path.name != RESPONSE or options.baseline or options.machine or options.window
    if measured:
        if options.settings:
            raise InputError("--set changes the scene of a run and does not apply to a recording. Leave it out.")
        window = tuple(options.window) if options.window else None
        judged = judge_file(path, options.baseline, options.machine, window)
        sys.stdout.write(json_text(file_facts(judged)) if options.json else file_words(judged))
        return 0
    from pipelines.diagnosis.export import diagnosis_facts
    from pipelines.diagnosis.uncertainty.words import bars_words
    from pipelines.engine.working import Work
    from pipelines.runs.diagnosed import diagnose_folder, folder_bars
    from pipelines.steps.diagnosing import words

    found = diagnose_folder(path.parent, options.settings)
    bars = folder_bars(path.parent, found, options.settings, Work())
    if options.json:
        facts = bars if isinstance(bars, str) else bars.to_dict()
        sys.stdout.write(json_text(diagnosis_facts([found]) | {"error_bars": facts}))
    else:
        sys.stdout.write(f"{words([found], [found])}\n{bars_words(bars)}")
    return 0
