"""`gearcase diagnose`: the damaged component in a recording, or the fault lines of a finished run."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pipelines.cli.command_line import MACHINE_HELP, RUN_HELP, json_argument
from pipelines.io.argument_types import number, path

HELP = """\
Find the damaged component from vibration. A measured recording is compared with recordings of healthy machines
(--baseline). A finished run is compared with its healthy control, and the spectral lines of both are listed.
Nothing is simulated. Takes seconds."""
EXAMPLE = """\
gearcase diagnose bench
Chipped tooth 10 of the stage 1 wheel: found. Evidence (steady, torque on the shaft, deviations of seed 1): ...
...
line                  Hz  faulty m/s²  healthy m/s²  difference dB  over floor dB  healthy over floor dB  mark
...
envelope f_r      10.081       0.0224       0.00656          +10.7          +28.7                  +22.8  detected
..."""


def arguments(sub: argparse.ArgumentParser) -> None:
    """Add the arguments: a recording or a run, its machine, and healthy recordings."""
    sub.add_argument(
        "run",
        metavar="RECORD",
        type=path,
        help=f"recording file, {RUN_HELP}",
    )
    sub.add_argument(
        "--machine",
        metavar="FILE",
        type=path,
        help=MACHINE_HELP,
    )
    sub.add_argument(
        "--baseline",
        metavar="RECORD",
        type=path,
        nargs="+",
        default=[],
        help="recordings of healthy machines to compare with; limits need 5 or more",
    )
    sub.add_argument(
        "--window",
        metavar=("START", "END"),
        type=number,
        nargs=2,
        help="time window to analyse, s (default: the windows of the scene, or all)",
    )
    sub.add_argument(
        "--out",
        metavar="FOLDER",
        type=path,
        help="folder for report.html: verdict, spectra with those of the first healthy recording, levels and features",
    )
    sub.add_argument(
        "--set",
        metavar="KEY=VALUE",
        dest="settings",
        action="append",
        default=[],
        help="change a setting of the diagnosis of a run, as in --set diagnosis.sensor=sensor_5; repeatable",
    )
    json_argument(sub)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Print the verdict and the tables of a recording, or of a run compared with its control, without simulation."""
    from pipelines.io.errors import InputError
    from pipelines.io.json_text import json_text
    from pipelines.io.shown import shown
    from pipelines.io.user_files import writable_folder
    from pipelines.runs.recorded import file_facts, file_words, judge_file, recorded_parts, recording_path
    from pipelines.runs.run_folder import RESPONSE

    path = recording_path(options.run)
    measured = path.name != RESPONSE or options.baseline or options.machine or options.window or options.out
    if measured:
        if options.settings:
            raise InputError(
                "--set does not apply to a recording, nor with --baseline, --machine, --window or --out. Delete it."
            )
        window = tuple(options.window) if options.window else None
        target = writable_folder(options.out) if options.out else None
        judged = judge_file(path, options.baseline, options.machine, window)
        yield json_text(file_facts(judged)) if options.json else file_words(judged)
        if target is not None:
            from pipelines.runs.recording_page import write_recording_page

            left = () if judged.verdict is None else judged.verdict.outlying
            healthy = [one for one in options.baseline if shown(one) not in left][:1]
            target.mkdir(parents=True, exist_ok=True)
            parts = recorded_parts([*healthy, options.run], options.machine, window)
            written = write_recording_page(target / "report.html", judged, parts)
            if not options.json:
                yield f"\nreport: {written}"
        return
    from pipelines.diagnosis.export import diagnosis_facts
    from pipelines.diagnosis.uncertainty.words import bars_words
    from pipelines.engine.run_graph import Work
    from pipelines.runs.diagnosed import diagnose_folder, folder_bars, judge_folder
    from pipelines.steps.diagnosing import words

    found, answered = diagnose_folder(path.parent, options.settings), judge_folder(path.parent)
    bars = folder_bars(path.parent, found, options.settings, Work())
    if options.json:
        facts = bars if isinstance(bars, str) else bars.to_dict()
        yield json_text({"verdict": answered["cases"]} | diagnosis_facts([found]) | {"error_bars": facts})
    else:
        answer = answered["words"] or f"No verdict: {answered['failure']}\n"
        yield f"{answer}\n{words([found])}\n{bars_words(bars)}"
