"""The sections of a report that show spectra and lines: each takes the results that it shows, and gives parts of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import xarray

from pipelines.diagnosis.control_diagnosis import Diagnosis
from pipelines.diagnosis.line_words import case_name, directions, lines_grid, seeds_grid
from pipelines.diagnosis.uncertainty.bar_records import LineBars
from pipelines.diagnosis.uncertainty.bar_words import bars_grid
from pipelines.report import page
from pipelines.report.chart_data import charts
from pipelines.report.figures.plots import waveform_figure
from pipelines.report.figures.spectrum_plots import (
    comparison_figure,
    error_bars_figure,
    healthy_faulty_figure,
    pass_figure,
    single_spectrum_figure,
    spectrum_figure,
)
from pipelines.signals.analysis import Analysis, DiagnosisSettings, analyse, channel_names
from pipelines.signals.levels import contact_sentence, level_grid
from pipelines.signals.levels import levels as measured_levels
from pipelines.signals.line_table import LOADS
from pipelines.signals.spectrum import Segment, Spectrum

Runs = Mapping[str, xarray.Dataset]
Windows = Mapping[str, tuple[float, float]]


def signals(
    runs: Runs,
    windows: Windows,
    point: tuple[str, str],
    diagnoses: Sequence[Diagnosis],
    alone: DiagnosisSettings | None,
) -> list[str]:
    """The charts that zoom, and the same as figures where no script runs.

    Parameters
    ----------
    runs, windows : responses, that of the scene first, and the windows of the diagnosis
    point : sensor and axis
    diagnoses, alone : the comparisons, and what to look at in a run without control
    """
    channel = _channel(runs, *point)
    if channel is None:
        return []
    settings = diagnoses[0].settings if diagnoses else alone
    band, spectra = None, []
    if diagnoses:
        band, spectra = diagnoses[0].band, _compared_spectra(diagnoses[0])
    elif settings is not None:
        own = analyse(next(iter(runs.values())), settings)
        band, spectra = own.band, _own_spectra(own, settings)
    caption = "Acceleration at the sensor without sensor noise: the whole run (left) and 0.1 s of it (right)."
    waveforms = page.picture(waveform_figure(runs, *channel, windows), caption, "static")
    return [charts(runs, channel, settings, band, windows), waveforms, *spectra]


def _channel(runs: Runs, sensor: str, axis: str) -> tuple[str, str] | None:
    """Sensor and axis of the verdict, the axis of the resultant otherwise; None if the runs do not have it."""
    if not runs or any(sensor not in channel_names(run) for run in runs.values()):
        return None
    axes = [str(one) for one in next(iter(runs.values())).axis.values]
    return sensor, axis if axis in axes else axes[-1]


def levels(runs: Runs, windows: Windows) -> list[str]:
    """Levels of every sensor, and how often and how long the drive flanks lost contact."""
    run = next(iter(runs.values()), None)
    if run is None:
        return []
    found, contact = measured_levels(run, windows), contact_sentence(run)
    parts = [page.table(level_grid(found))] if found else []
    return parts + ([page.paragraph(contact)] if contact else [])


def _compared_spectra(diagnosis: Diagnosis) -> list[str]:
    parts = []
    for window, segment in diagnosis.segments.items():
        caption = (
            f"{_named(diagnosis, window)}: one-sided peak amplitudes over {segment.revolutions} revolutions of the "
            f"shaft of the damaged gear ({_length(segment)}), Hann window, "
            f"sensor noise {diagnosis.noise:.3g} m/s² rms."
        )
        parts.append(page.picture(spectrum_figure(diagnosis, window), caption, "static"))
    return parts


def _length(segment: Segment) -> str:
    """That of a spectrum, with the reason why it may have fewer revolutions than an average."""
    reason = "" if segment.resampled else ", the longest part with whole numbers of revolutions and samples"
    return f"{segment.duration:.4g} s{reason}"


def _own_spectra(analysis: Analysis, settings: DiagnosisSettings) -> list[str]:
    """Spectra of the run alone, where there is no control."""
    parts = []
    for window, spectrum in analysis.spectra.items():
        title = f"Spectrum at {settings.sensor} ({settings.axis}), {window}"
        segment = analysis.segments[window]
        caption = (
            f"Spectrum in the window {window}: one-sided peak amplitudes over {segment.revolutions} revolutions of the "
            f"shaft with f_r ({_length(segment)}), Hann window, with sensor noise."
        )
        parts.append(page.picture(single_spectrum_figure(spectrum, settings, title), caption, "static"))
    return parts


def healthy_faulty(diagnoses: Sequence[Diagnosis], error: LineBars | str) -> list[str]:
    parts = []
    for number, diagnosis in enumerate(diagnoses):
        for window in diagnosis.settings.windows:
            bars = error.of(window) if isinstance(error, LineBars) and number == 0 else ()
            caption = f"{_named(diagnosis, window)}: healthy and faulty run. Triangles: detected lines."
            if any(bar.numerical is not None for bar in bars):
                caption += " Black bar on a line: its numerical uncertainty."
            caption += " Yellow bar next to a line: range of its level for uncertain damping." if bars else ""
            parts.append(page.picture(healthy_faulty_figure(diagnosis, window, bars), caption))
            for spall in diagnosis.settings.passes:
                parts.append(page.picture(pass_figure(diagnosis, window, spall), f"{caption} Dashed: {spall.label}."))
    return parts


def error_bars(error: LineBars | str) -> list[str]:
    """Numerical uncertainty of the lines, and the effect of uncertain inputs on them."""
    if isinstance(error, str):
        return [page.paragraph(error)] if error else []
    windows = dict.fromkeys(bar.window for bar in error.bars)
    parts = []
    for window in windows:
        bars = error.of(window)
        known = "numerical uncertainty, and by " if any(bar.numerical is not None for bar in bars) else ""
        caption = (
            f"Error bars in the window {window}: change of the level of a line by {known}uncertain damping. Lines that "
            "are not clearly over their floor are left out."
        )
        parts += [page.picture(error_bars_figure(bars, window), caption), page.table(bars_grid(bars, window))]
        parts += [page.note("Detected lines are shaded.")] if any(bar.detected for bar in bars) else []
    return [*parts, *map(page.paragraph, error.notes)]


def two_windows(diagnoses: Sequence[Diagnosis]) -> list[str]:
    parts = []
    for diagnosis in diagnoses:
        windows = list(diagnosis.settings.windows)[:2]
        if len(windows) < 2:
            continue
        pairs = {window: _faulty(diagnosis, window) for window in windows}
        title = f"Faulty run, {' and '.join(windows)}, {LOADS.get(diagnosis.load, diagnosis.load)}"
        parts.append(page.picture(comparison_figure(pairs, diagnosis.settings, title), title + "."))
        parts.append(page.paragraph(directions(diagnosis)))
    return parts


def two_loads(diagnoses: Sequence[Diagnosis]) -> list[str]:
    by_load = {diagnosis.load: diagnosis for diagnosis in diagnoses}
    if not {"rope", "static-torque"} <= set(by_load):
        return []
    rope, torque = by_load["rope"], by_load["static-torque"]
    parts = []
    for window in rope.settings.windows:
        pairs = {LOADS["rope"]: _faulty(rope, window), LOADS["static-torque"]: _faulty(torque, window)}
        title = f"Faulty run, rope and constant torque, {window}"
        figure = comparison_figure(pairs, rope.settings, title, window=window)
        parts.append(page.picture(figure, title + "."))
    return parts


def all_lines(diagnoses: Sequence[Diagnosis], seeds: Sequence[Diagnosis]) -> list[str]:
    if not diagnoses:
        return []
    settings = diagnoses[0].settings
    parts = [
        page.paragraph(
            f"Lines at {settings.sensor} ({settings.axis}): harmonics of f_r in the envelope spectrum, and sidebands "
            "n f_m + k f_r in the spectrum. Difference: faulty over healthy. Over floor: level over the median of the "
            "spectrum within one f_r of the line, without the bins of the orders. Detected lines are shaded; - means "
            "not detected. A mesh line or a bearing line is given for comparison and is no evidence of the fault. Both "
            f"runs contain sensor noise of {diagnoses[0].noise:.3g} m/s² rms."
            + (
                ' With a container on a rope, the last column gives its natural frequency. "on this line" marks lines '
                "that this oscillation can raise without a fault."
                if settings.rope_mode
                else ""
            )
        )
    ]
    for diagnosis in diagnoses:
        parts += [page.table(lines_grid(diagnosis, window)) for window in diagnosis.settings.windows]
    every = [*diagnoses, *seeds]
    if seeds:
        for load in dict.fromkeys(d.load for d in every):
            parts += [page.table(seeds_grid(every, load, window)) for window in settings.windows]
    for diagnosis in seeds:
        inside = "".join(page.table(lines_grid(diagnosis, window)) for window in diagnosis.settings.windows)
        parts.append(page.folded(f"Lines of {case_name(diagnosis)}", inside))
    return parts


def _faulty(diagnosis: Diagnosis, window: str) -> tuple[Spectrum, Spectrum]:
    return diagnosis.spectra["faulty", window], diagnosis.envelopes["faulty", window]


def _named(diagnosis: Diagnosis, window: str) -> str:
    return f"{window.capitalize()}, {case_name(diagnosis)}"
