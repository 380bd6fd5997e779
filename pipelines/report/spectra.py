"""The sections of a report that show spectra and lines: each takes the contents and gives parts of the page."""

from __future__ import annotations

from pipelines.diagnosis.control_diagnosis import Diagnosis
from pipelines.diagnosis.control_verdict import case_name, directions, lines_grid, seeds_grid
from pipelines.diagnosis.uncertainty.line_bars import LineBars
from pipelines.diagnosis.uncertainty.words import bars_grid
from pipelines.report import page
from pipelines.report.contents import ReportContents
from pipelines.report.figures.plots import waveform_figure
from pipelines.report.figures.spectrum_plots import (
    Trace,
    comparison_figure,
    error_bars_figure,
    healthy_faulty_figure,
    pass_figure,
    single_spectrum_figure,
    spectrum_figure,
)
from pipelines.report.zoom import charts
from pipelines.report.zoom_data import channels, views
from pipelines.signals.analysis import Analysis, DiagnosisSettings, analyse
from pipelines.signals.levels import contact_sentence, level_grid
from pipelines.signals.lines import LOADS


def signals(contents: ReportContents) -> list[str]:
    """The charts that zoom, and the same as figures where no script runs."""
    if contents.channel is None:
        return []
    settings = contents.diagnoses[0].settings if contents.diagnoses else contents.settings
    own = None
    if settings is not None and not contents.diagnoses:
        own = analyse(next(iter(contents.runs.values())), settings)
    band = contents.diagnoses[0].band if contents.diagnoses else None if own is None else own.band
    found = channels(contents.runs, contents.channel, settings, band)
    parts = [charts(list(contents.runs), views(settings, band), found, contents.windows), _waveforms(contents)]
    return parts + (_compared_spectra(contents) if own is None or settings is None else _own_spectra(own, settings))


def levels(contents: ReportContents) -> list[str]:
    """Levels of every sensor, and how often and how long the drive flanks lost contact."""
    run = next(iter(contents.runs.values()), None)
    if run is None:
        return []
    found, contact = level_grid(run, contents.windows), contact_sentence(run)
    parts = [] if found is None else [page.table(found)]
    if found is not None:
        parts.append(page.note("Resultant: root sum square of the axes of a sensor."))
    return parts + ([page.paragraph(contact)] if contact else [])


def _waveforms(contents: ReportContents) -> str:
    assert contents.channel is not None
    figure = waveform_figure(contents.runs, *contents.channel, contents.windows)
    caption = "Acceleration at the sensor without sensor noise: the whole run (left) and 0.1 s of it (right)."
    return page.picture(figure, caption, "static")


def _compared_spectra(contents: ReportContents) -> list[str]:
    parts = []
    for diagnosis in contents.diagnoses[:1]:
        for window in diagnosis.settings.windows:
            segment = diagnosis.segments[window]
            caption = (
                f"{_named(diagnosis, window)}: one-sided peak amplitudes over {segment.revolutions} revolutions of the "
                f"shaft of the damaged gear ({segment.duration:.4g} s), {_window_name(diagnosis.settings)}, "
                f"sensor noise {diagnosis.noise:.3g} m/s² rms."
            )
            parts.append(page.picture(spectrum_figure(diagnosis, window), caption, "static"))
    return parts


def _own_spectra(analysis: Analysis, settings: DiagnosisSettings) -> list[str]:
    """Spectra of the run alone, where there is no control."""
    parts = []
    for window, spectrum in analysis.spectra.items():
        title = f"Spectrum at {settings.sensor} ({settings.axis}), {window}"
        segment = analysis.segments[window]
        caption = (
            f"{window.capitalize()}: one-sided peak amplitudes over {segment.revolutions} revolutions of the shaft "
            f"with f_r ({segment.duration:.4g} s), {_window_name(settings)}, with sensor noise."
        )
        parts.append(page.picture(single_spectrum_figure(spectrum, settings, title), caption, "static"))
    return parts


def healthy_faulty(contents: ReportContents) -> list[str]:
    parts = []
    for number, diagnosis in enumerate(contents.diagnoses):
        for window in diagnosis.settings.windows:
            bars = contents.bars.of(window) if isinstance(contents.bars, LineBars) and number == 0 else ()
            caption = f"{_named(diagnosis, window)}: healthy and faulty run. Triangles: detected lines."
            if any(bar.numerical is not None for bar in bars):
                caption += " Black bar on a line: its numerical uncertainty."
            caption += " Yellow bar next to a line: range of its level for uncertain damping." if bars else ""
            parts.append(page.picture(healthy_faulty_figure(diagnosis, window, bars), caption))
            for spall in diagnosis.settings.passes:
                parts.append(page.picture(pass_figure(diagnosis, window, spall), f"{caption} Dashed: {spall.label}."))
    return parts


def error_bars(contents: ReportContents) -> list[str]:
    """Numerical uncertainty of the lines, and the effect of uncertain inputs on them."""
    if isinstance(contents.bars, str):
        return [page.paragraph(contents.bars)] if contents.bars else []
    windows = dict.fromkeys(bar.window for bar in contents.bars.bars)
    parts = []
    for window in windows:
        bars = contents.bars.of(window)
        known = "numerical uncertainty, and by " if any(bar.numerical is not None for bar in bars) else ""
        caption = (
            f"Error bars in the window {window}: change of the level of a line by {known}uncertain damping. Lines that "
            "are not clearly over their floor are left out."
        )
        parts += [page.picture(error_bars_figure(bars, window), caption), page.table(bars_grid(bars, window))]
        parts += [page.note("Detected lines are shaded.")] if any(bar.detected for bar in bars) else []
    return [*parts, *map(page.paragraph, contents.bars.notes)]


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


def all_lines(contents: ReportContents) -> list[str]:
    if not contents.diagnoses:
        return []
    settings = contents.diagnoses[0].settings
    parts = [
        page.paragraph(
            f"Lines at {settings.sensor} ({settings.axis}): harmonics of f_r in the envelope spectrum, and sidebands "
            "n f_m + k f_r in the spectrum. Difference: faulty over healthy. Over floor: over the median of the bins "
            "between the orders, one f_r to either side. Detected lines are shaded; - means not detected. A mesh line "
            "or a bearing line is given for comparison and is no evidence of the fault. Both runs contain sensor noise "
            f"of {contents.diagnoses[0].noise:.3g} m/s² rms."
            + (
                ' The last column gives the natural frequency of the container on its rope. "on this line" marks lines '
                "that it can raise without a fault."
                if settings.rope_mode
                else ""
            )
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


def _window_name(settings: DiagnosisSettings) -> str:
    return f"{settings.spectrum_window.capitalize()} window"


def _trace(diagnosis: Diagnosis, window: str, name: str) -> Trace:
    return Trace(
        name=name, spectrum=diagnosis.spectra["faulty", window], envelope=diagnosis.envelopes["faulty", window]
    )


def _named(diagnosis: Diagnosis, window: str) -> str:
    return f"{window.capitalize()}, {case_name(diagnosis)}"
