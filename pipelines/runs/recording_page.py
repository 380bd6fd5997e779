"""Page of a diagnosed recording: the verdict, spectra over a healthy recording, levels, and all features."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pipelines.diagnosis import verdict_words
from pipelines.diagnosis.comparison.compared_features import features_of
from pipelines.diagnosis.comparison.compared_recording import (
    Channel,
    ComparedRecording,
    brought_together,
    chosen_channel,
)
from pipelines.diagnosis.comparison.comparison_words import LETTERS, recordings_grid
from pipelines.diagnosis.comparison.curves import curves
from pipelines.diagnosis.impacts import impact_words
from pipelines.io.user_files import write_whole
from pipelines.report import page
from pipelines.report.figures.comparison_plots import comparison_figures
from pipelines.runs.judged_recording import JudgedFile
from pipelines.runs.judged_words import features_grid
from pipelines.signals.levels import level_grid

_CAPTIONS = {  # by the beginning of the name of a figure
    "orders": "Order spectra. Dashed: mesh orders.",
    "sidebands": "Order spectra around a mesh order. Dashed: sidebands at multiples of the shaft speeds.",
    "envelope": "Order spectra of the squared envelope. Dashed: shafts, and pass frequencies of bearings.",
    "cepstrum": "Real cepstra (Randall 2011): sidebands or harmonics at the distance of a shaft give lines at 1, 2, 3 "
    "turns of it (dashed). Damage of a tooth raises their sum for the shaft of its gear. Pitch deviations cause them, "
    "too, so compare only recordings of the same machine.",
    "average": "Time-synchronous averages over a revolution.",
    "rms": "Root mean square of every sensor.",
}
_BEHIND = " Grey: the healthy recording."


def write_recording_page(path: Path, judged: JudgedFile, recorded: Sequence[ComparedRecording]) -> Path:
    """Write the page as one HTML file with all figures inside; returns the path.

    Parameters
    ----------
    path : of the file
    judged : the recording with its features and its verdict, if there is one
    recorded : a healthy recording, if there is one, and the recording

    Raises
    ------
    FeatureError : too few revolutions for spectra
    """
    verdict, own, title = judged.verdict, judged.recorded, f"Diagnosis of {recorded[-1].name}"
    answer = (impact_words(own.table),) if verdict is None else verdict_words.sentences(verdict)
    damaged = any(one.clear for one in judged.impacts) or None if verdict is None else verdict.damaged
    incomplete = damaged is None or (verdict is not None and verdict.not_examined)
    style = "fault" if damaged else "open" if incomplete else "none"
    sentences = "".join(map(page.paragraph, answer))
    body = [
        page.heading(title, 1),
        *(page.paragraph(f"Warning: {warning}", "caution") for warning in own.warnings),
        f'<div class="verdict {style}" id="verdict">{sentences}</div>',
        page.paragraph(own.turning),
    ]
    if verdict is not None:
        body.append(page.table(verdict_words.ranking_grid(verdict)) + page.note(verdict_words.note(verdict)))
    body.append(page.section("Spectra and averages", _figures(judged, recorded), opened=True))
    if own.levels:
        body.append(page.section("Levels", [page.table(level_grid(own.levels))]))
    body.append(page.section("Features", [page.table(features_grid(own.table))]))
    body.append(page.section("Recordings", [page.table(recordings_grid(recorded))]))
    write_whole(path, page.document(title, body))
    return path


def _figures(judged: JudgedFile, recorded: Sequence[ComparedRecording]) -> list[str]:
    parts = brought_together(recorded)
    features = features_of(parts)
    components = features.tables[-1].component
    drawn = curves(parts, _channel(judged, parts[-1]), _shaft(judged, components))
    names = [f"{letter}  {part.name}" for letter, part in zip(LETTERS, parts, strict=False)]
    behind = _BEHIND if len(parts) > 1 else ""
    return [
        page.picture(figure, _CAPTIONS[name.partition("-")[0]] + ("" if name == "rms" else behind))
        for name, figure in comparison_figures(drawn, features, parts, names).items()
        if name.partition("-")[0] != "average" or drawn.shaft in components  # else its angle is not known well enough
    ]


def _channel(judged: JudgedFile, part: ComparedRecording) -> Channel:
    """That of the strongest evidence, else the one with the highest rms."""
    if judged.verdict is not None or judged.impacts:
        shown = judged.impacts[0] if judged.verdict is None else judged.verdict.first.evidence
        if (shown.sensor, shown.axis) in part.channels:
            return shown.sensor, shown.axis
    return chosen_channel(part, None, None)


def _shaft(judged: JudgedFile, components: Sequence[str]) -> str:
    """The shaft of the strongest evidence, else the first one that turns often enough."""
    turning = [shaft.name for shaft in judged.kinematics.shafts if shaft.name in components]
    first = "" if judged.verdict is None else judged.kinematics.shaft_of(judged.verdict.first.component)
    return first if first in turning else [*turning, judged.kinematics.shafts[0].name][0]
