"""`gearcase diagnose`: the damaged component in a recording, or the fault lines of a finished run."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from pipelines.cli.command_line import JSON, MACHINE, RUN_HELP, argument
from pipelines.io.argument_types import number, path

ARGUMENTS = (
    argument(
        "records",
        metavar="RECORD",
        type=path,
        nargs="+",
        help=f"recording file, {RUN_HELP}; add a time window by its name or in s, as in bench@0.5:2.5",
    ),
    MACHINE,
    argument(
        "--baseline",
        metavar="RECORD",
        type=path,
        nargs="+",
        default=[],
        help="recordings of healthy machines to compare with; limits need 5 or more",
    ),
    argument(
        "--window",
        metavar=("START", "END"),
        type=number,
        nargs=2,
        help="time window to analyse, s (default: the windows of the scene, or the whole recording)",
    ),
    argument(
        "--out",
        metavar="FOLDER",
        type=path,
        help="folder for report.html: verdict, levels, features, spectra of the recording and of the first healthy "
        "one; for several recordings the trend, and a folder 1, 2, ... with the report of each",
    ),
    argument(
        "--set",
        metavar="KEY=VALUE",
        dest="settings",
        action="append",
        default=[],
        help="change a setting of the diagnosis of a run, as in --set diagnosis.sensor=sensor_5; repeatable",
    ),
    JSON,
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Find the damaged component from vibration. A measured recording is compared with recordings of healthy machines
    (--baseline). A finished run is compared with its healthy control, and the spectral lines of both are listed.
    Several recordings give a table; those that cannot be used are refused in it. Nothing is simulated. Takes seconds.

    Example
    -------
    gearcase diagnose bench
    Chipped tooth 10 of the stage 1 wheel: found. Evidence (steady, torque load, deviations of seed 1): ...
    ...
    line                  Hz  faulty m/s²  healthy m/s²  difference dB  over floor dB  healthy over floor dB  mark
    ...
    envelope f_r      10.081       0.0224       0.00656          +10.7          +28.7                  +22.8  detected
    ...
    """
    from pipelines.runs.recorded_file import recording_and_window
    from pipelines.runs.run_folder import RESPONSE

    path, asked = recording_and_window(options.records[0])
    compared = options.baseline or options.machine or options.window or options.out or asked
    if len(options.records) > 1 or compared or path.name != RESPONSE:
        yield from _recordings(options)
    else:
        yield from _run(options, path.parent)


def _recordings(options: argparse.Namespace) -> Iterator[str]:
    from pipelines.diagnosis.trend import trend_facts, trend_grid
    from pipelines.io.errors import InputError
    from pipelines.io.json_text import json_text
    from pipelines.io.shown_text import shown
    from pipelines.io.text_table import WIDTH
    from pipelines.io.user_files import writable_folder
    from pipelines.runs.judged_recording import courses_of, judge_files, notes_of, order_of
    from pipelines.runs.judged_words import file_facts, file_words, files_grid
    from pipelines.runs.recorded_file import recorded_parts

    if options.settings:
        raise InputError(
            "--set applies only to a finished run, without --baseline, --machine, --window and --out. Delete --set."
        )
    window = tuple(options.window) if options.window else None
    target = writable_folder(options.out) if options.out else None
    several = len(options.records) > 1
    refused: dict[str, str] = {}
    judged = list(judge_files(options.records, options.baseline, options.machine, window, refused if several else None))
    if not judged:
        raise InputError(next(iter(refused.values())))
    numbers, order, timed = order_of(judged)
    used = [one for one in options.records if shown(one) not in refused]
    judged, records = [judged[number] for number in numbers], [used[number] for number in numbers]
    names, courses = [shown(one) for one in records], courses_of(judged)
    if options.json:
        facts = [file_facts(one) for one in judged]
        trend = {"order": order, "recordings": facts, "refused": refused, "trend": trend_facts(courses, names)}
        yield json_text(trend if several else facts[0])
    elif several:
        table = files_grid(names, judged, refused).to_text(WIDTH)
        yield f"{table}\n{order}\n\n{trend_grid(courses).to_text(WIDTH)}\n"
        yield from (f"Refused: {reason}" for reason in refused.values())
        yield from notes_of(judged)
    else:
        yield file_words(judged[0])
    if target is None:
        return
    from pipelines.runs.recording_page import write_recording_page
    from pipelines.runs.trend_page import write_trend_page

    for place, (name, one) in enumerate(zip(names, judged, strict=True), 1):
        left = () if one.verdict is None else one.verdict.outlying
        healthy = [other for other in options.baseline if shown(other) not in left][:1]
        folder = target / str(place) if several else target
        folder.mkdir(parents=True, exist_ok=True)
        parts = recorded_parts([*healthy, records[place - 1]], options.machine, window)
        written = write_recording_page(folder / "report.html", one, parts)
        if not options.json:
            yield f"report of {name}: {written}" if several else f"\nreport: {written}"
    if several:
        written = write_trend_page(target / "report.html", names, judged, refused, order, timed, courses)
        if not options.json:
            yield f"trend: {written}"


def _run(options: argparse.Namespace, folder: Path) -> Iterator[str]:
    from pipelines.diagnosis.result_export import diagnosis_facts
    from pipelines.diagnosis.uncertainty.bar_words import bars_words
    from pipelines.engine.run_graph import Work
    from pipelines.io.json_text import json_text
    from pipelines.runs.diagnosed_run import diagnose_folder, folder_bars, judge_folder
    from pipelines.runs.run_folder import RESPONSE, opened_run
    from pipelines.signals.levels import level_grid, levels
    from pipelines.steps.diagnosing import words

    found, answered = diagnose_folder(folder, options.settings), judge_folder(folder)
    bars = folder_bars(folder, found, options.settings, Work())
    with opened_run(folder / RESPONSE) as run:
        measured = levels(run, found.settings.windows)
    if options.json:
        own = {"error_bars": bars, "levels": measured}
        yield json_text({"verdict": answered["cases"]} | diagnosis_facts([found]) | own)
    else:
        answer = answered["words"] or f"No verdict: {answered['failure']}\n"
        yield f"{answer}\n{words([found])}\n{bars_words(bars)}"
        if measured:
            yield f"\n{level_grid(measured).to_text()}"
