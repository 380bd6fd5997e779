"""`gearcase compare`: recordings side by side, measured or simulated."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.cli.command_line import MACHINE, argument
from pipelines.io.argument_types import count, path
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.io.user_files import is_regular_file, writable_folder, write_whole
from pipelines.runs import run_folder
from pipelines.runs.recorded_file import machine_of, recording_and_window, requested_windows

if TYPE_CHECKING:
    from pipelines.diagnosis.comparison.compared_features import Features
    from pipelines.diagnosis.comparison.compared_recording import ComparedRecording
    from pipelines.diagnosis.comparison.curves import Curves

MOST_NAME = 60  # characters of the name of a recording in a table
FOLDER = "comparison"
ARGUMENTS = (
    argument(
        "recordings",
        metavar="RECORD",
        type=path,
        nargs="+",
        help="2 to 10 recording files, or runs by folder, scene name or number; add a time window by its name or in s, "
        "as in bench@steady or bench@0.5:2.5",
    ),
    MACHINE,
    argument("--sensor", metavar="NAME", help="sensor in the figures (default: that with the highest level)"),
    argument("--axis", choices=("x", "y", "z"), help="axis of the sensor (default: that with the highest level)"),
    argument(
        "--shaft",
        metavar="N",
        type=count,
        help="number of the shaft of the time-synchronous averages (default: that whose features differ most)",
    ),
    argument("--out", metavar="FOLDER", type=path, help="folder for figures and CSV (default: ./comparison)"),
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Compare recordings, measured or simulated. Print a table of features and write it as CSV. Write figures of order
    spectra, envelope spectra and time-synchronous averages. The first recording is the reference. Takes seconds.

    Example
    -------
    gearcase compare bench@0.5:0.9 bench@0.9:1.3
       recording               s  turns   rpm  f_m Hz  samples/s  speed from
    -  -------------  ----------  -----  ----  ------  ---------  -------------------------
    A  bench@0.5:0.9  0.5 to 0.9   10.0  1500     625      12800  recorded angle of shaft_1
    B  bench@0.9:1.3  0.9 to 1.3   10.0  1500     625      12800  recorded angle of shaft_1
    ...
    comparison/features.csv
    """
    from pipelines.diagnosis.comparison.compared_features import features_of
    from pipelines.diagnosis.comparison.compared_recording import brought_together, chosen_channel
    from pipelines.diagnosis.comparison.comparison_words import (
        LETTERS,
        features_csv,
        features_grid,
        recordings_grid,
        remarks,
    )
    from pipelines.diagnosis.comparison.curves import curves
    from pipelines.signals.features.recording_features import FeatureError

    sources = options.recordings
    if not 2 <= len(sources) <= len(LETTERS):
        raise InputError(f"{len(sources)} recording{'' if len(sources) == 1 else 's'} given. Give 2 to {len(LETTERS)}.")
    target = writable_folder(options.out or FOLDER)
    recorded = _read(sources, options.machine)
    try:
        parts = brought_together(recorded)
        found = features_of(parts)
        drawn = curves(
            parts, chosen_channel(parts[0], options.sensor, options.axis), _shaft(parts, found, options.shaft)
        )
    except FeatureError as error:
        raise InputError(str(error)) from error
    files = _write(target, drawn, found, parts)
    write_whole(target / "features.csv", features_csv(found))
    texts = [recordings_grid(recorded).to_text(), *remarks(recorded, parts, found), features_grid(found).to_text()]
    if any(len(part.windows) > 1 for part in parts):
        texts.append("Features are means over the windows, figures show the first. Select a window with RECORD@WINDOW.")
    yield from (f"{text}\n\n" for text in texts)
    yield from map(str, [*files, target / "features.csv"])


def _read(sources: Sequence[str], machine: str | Path | None) -> list[ComparedRecording]:
    """Every recording with its machine: the one that is given, its own scene, or that of the first that has one."""
    from pipelines.diagnosis.comparison.compared_recording import compared_recording
    from pipelines.recordings.read_recording import read_recording
    from pipelines.signals.features.recording_features import FeatureError
    from pipelines.signals.orders.rotation import RotationError

    split = [recording_and_window(source) for source in sources]
    scenes = [file.parent / run_folder.RESOLVED for file, _ in split]
    other = next((scene for scene in scenes if is_regular_file(scene)), None)
    parts = []
    for source, (file, window), scene in zip(sources, split, scenes, strict=True):
        known, windows = machine_of(file, machine or (None if is_regular_file(scene) else other))
        name = shown(source) if len(source) <= MOST_NAME else f"...{shown(source[3 - MOST_NAME :])}"
        with read_recording(file, known) as recording:
            try:
                parts.append(
                    compared_recording(name, recording, known.kinematics, requested_windows(source, window, windows))
                )
            except (FeatureError, RotationError) as error:
                raise InputError(f"{shown(source)}: {error}") from error
    return parts


def _shaft(parts: Sequence[ComparedRecording], found: Features, number: int | None) -> str:
    """The shaft whose turns are averaged."""
    from pipelines.diagnosis.comparison.compared_features import most_different_shaft

    there = [
        shaft.name
        for shaft in parts[0].kinematics.shafts
        if all(shaft.name in table.component for table in found.tables)
    ]
    if number is None:
        return most_different_shaft(found, parts[0].kinematics, there)
    shafts = parts[0].kinematics.shafts
    if number > len(shafts) or shafts[number - 1].name not in there:
        raise InputError(
            f"--shaft {number}: no shaft of this number makes enough revolutions in all recordings. Give the number of "
            f"one of {', '.join(there)}, or set longer windows."
        )
    return shafts[number - 1].name


def _write(target: Path, drawn: Curves, found: Features, parts: Sequence[ComparedRecording]) -> list[Path]:
    """The figures as SVG."""
    from pipelines.diagnosis.comparison.comparison_words import LETTERS
    from pipelines.report.figures.comparison_plots import comparison_figures
    from pipelines.report.figures.frame_files import save_figure

    names = [f"{letter}  {part.name}" for letter, part in zip(LETTERS, parts, strict=False)]
    pictures = comparison_figures(drawn, found, parts, names)
    target.mkdir(parents=True, exist_ok=True)
    files = [target / f"{name}.svg" for name in pictures]
    for file, figure in zip(files, pictures.values(), strict=True):
        save_figure(figure, file, dpi=110)
    return files
