"""The sections of a report that show spectra and lines: each takes the contents and gives parts of the page."""

from __future__ import annotations

from pipelines.figures.spectrum_plots import (
    Trace,
    comparison_figure,
    healthy_faulty_figure,
    single_spectrum_figure,
    spectrum_figure,
)
from pipelines.report import page
from pipelines.report.contents import ReportContents
from pipelines.signals.analysis import analyse, channel_names
from pipelines.signals.diagnosis import Diagnosis
from pipelines.signals.lines import LOADS
from pipelines.signals.verdict import case_name, directions, lines_grid, seeds_grid


def spectra(contents: ReportContents) -> list[str]:
    if not contents.diagnoses:
        return _own_spectra(contents)
    parts = []
    for diagnosis in contents.diagnoses[:1]:
        for window in diagnosis.settings.windows:
            segment = diagnosis.segments[window]
            caption = (
                f"{_named(diagnosis, window)}: one-sided peak amplitudes over {segment.revolutions} revolutions of the "
                f"faulty shaft ({segment.duration:.4g} s), {diagnosis.settings.spectrum_window} window, "
                f"sensor noise {diagnosis.noise:.3g} m/s² rms."
            )
            parts.append(page.picture(spectrum_figure(diagnosis, window), caption))
    return parts


def _own_spectra(contents: ReportContents) -> list[str]:
    """Spectra of the run alone, where there is no control."""
    run = next(iter(contents.runs.values()), None)
    if run is None or contents.settings is None or contents.settings.sensor not in channel_names(run):
        return []
    analysis = analyse(run, contents.settings)
    parts = []
    for window, spectrum in analysis.spectra.items():
        title = f"Spectrum at {contents.settings.sensor} ({contents.settings.axis}), {window}"
        segment = analysis.segments[window]
        caption = (
            f"One-sided peak amplitudes over {segment.revolutions} revolutions of the shaft with f_r "
            f"({segment.duration:.4g} s), {contents.settings.spectrum_window} window, with sensor noise."
        )
        parts.append(page.picture(single_spectrum_figure(spectrum, contents.settings, title), caption))
    return parts


def healthy_faulty(contents: ReportContents) -> list[str]:
    parts = []
    for diagnosis in contents.diagnoses:
        for window in diagnosis.settings.windows:
            caption = f"{_named(diagnosis, window)}: both runs with the same deviations. Triangles: detected lines."
            parts.append(page.picture(healthy_faulty_figure(diagnosis, window), caption))
    return parts


def two_windows(contents: ReportContents) -> list[str]:
    parts = []
    for diagnosis in contents.diagnoses:
        windows = list(diagnosis.settings.windows)[:2]
        if len(windows) < 2:
            continue
        traces = [_trace(diagnosis, window, window) for window in windows]
        title = f"Faulty run, {' and '.join(windows)}, {LOADS.get(diagnosis.load, diagnosis.load)}"
        parts.append(page.picture(comparison_figure(traces, diagnosis.settings, title), title + "."))
        parts.append(page.paragraph(directions(diagnosis)))
    return parts


def two_loads(contents: ReportContents) -> list[str]:
    by_load = {diagnosis.load: diagnosis for diagnosis in contents.diagnoses}
    if not {"rope", "static-torque"} <= set(by_load):
        return []
    rope, torque = by_load["rope"], by_load["static-torque"]
    parts = []
    for window in rope.settings.windows:
        traces = [_trace(rope, window, LOADS["rope"]), _trace(torque, window, LOADS["static-torque"])]
        title = f"Faulty run, rope and constant torque, {window}"
        figure = comparison_figure(traces, rope.settings, title, window=window)
        parts.append(page.picture(figure, title + "."))
    return parts


def envelope_table(contents: ReportContents) -> list[str]:
    if not contents.diagnoses:
        return []
    settings = contents.diagnoses[0].settings
    parts = [
        page.paragraph(
            f"Harmonics of f_r in the envelope and sidebands n f_m + k f_r in the spectrum at {settings.sensor} "
            f"({settings.axis}); detected lines are shaded. The floor is the median between the orders, one f_r to "
            "either side. The stated sensor noise is in both runs."
            + (" The rope mode is printed beside each line." if settings.rope_mode else "")
        )
    ]
    for diagnosis in contents.diagnoses:
        parts += [page.table(lines_grid(diagnosis, window)) for window in diagnosis.settings.windows]
    every = [*contents.diagnoses, *contents.seeds]
    if contents.seeds:
        for load in dict.fromkeys(d.load for d in every):
            parts += [page.table(seeds_grid(every, load, window)) for window in settings.windows]
    for diagnosis in contents.seeds:
        inside = "".join(page.table(lines_grid(diagnosis, window)) for window in diagnosis.settings.windows)
        parts.append(page.folded(f"Lines of {case_name(diagnosis)}", inside))
    return parts


def _trace(diagnosis: Diagnosis, window: str, name: str) -> Trace:
    return Trace(
        name=name, spectrum=diagnosis.spectra["faulty", window], envelope=diagnosis.envelopes["faulty", window]
    )


def _named(diagnosis: Diagnosis, window: str) -> str:
    return f"{window.capitalize()}, {case_name(diagnosis)}"
