"""Figures of spectra with the lines of the fault marked. Every function returns the figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator

from pipelines.diagnosis.control_diagnosis import Diagnosis, DiagnosisSettings
from pipelines.diagnosis.uncertainty.bar_records import LineBar
from pipelines.report.figures.colours import FAULTY, HEALTHY
from pipelines.report.figures.plots import (
    FIRST,
    LETTER,
    MARK,
    SECOND,
    dress,
    fixed_figure,
    legend,
    plain,
    plain_symbols,
)
from pipelines.signals.line_table import LOADS
from pipelines.signals.pass_lines import HARMONICS, PassLines
from pipelines.signals.spectrum import Spectrum

ROPE = "#7a5195"
NUMERICAL, INPUTS = "#111111", "#e08e0b"
OFFSET = 0.006  # of the width of an axes, from the numerical error bar to that of the inputs
DECADES = 5.0  # range of a spectrum below its top


Spectra = Mapping[str, tuple[Spectrum, Spectrum]]  # spectrum and envelope spectrum of each case by its name


def spectrum_figure(diagnosis: Diagnosis, window: str) -> Figure:
    """Faulty over healthy spectrum up to four mesh orders, with f_r, the mesh orders and their sidebands marked."""
    settings = diagnosis.settings
    load = LOADS.get(diagnosis.load, diagnosis.load)
    title = f"Spectrum at {settings.sensor} ({settings.axis}), {plain(window)}, {load}"
    figure = fixed_figure(5.4, title=title, rows=2, down=0.45)
    panels = figure.subplots(2, 1, sharex=True, sharey=True)
    end = 4.4 * settings.mesh_frequency
    for axes, state, colour in zip(panels, ("faulty", "healthy"), (FAULTY, HEALTHY), strict=True):
        spectrum = diagnosis.spectra[state, window]
        _draw_spectrum(axes, spectrum, (0.0, end), colour, state)
        _mark_orders(axes, settings)
        lines = diagnosis.lines.where(window=window, kind="sideband")
        axes.plot(
            lines.frequency,
            getattr(lines, state),
            "o",
            ms=3.5,
            mfc="none",
            mec="black",
            mew=0.7,
            label="sidebands k fᵣ",
        )
        dress(axes, f"{state.capitalize()}", "frequency, Hz" if state == "healthy" else "", "amplitude, m/s²")
        legend(axes)
    _limit_decades(*panels)
    return figure


def single_spectrum_figure(spectrum: Spectrum, settings: DiagnosisSettings, title: str) -> Figure:
    """Spectrum of one run without a control, up to four mesh orders with f_r and the mesh orders marked."""
    figure = fixed_figure(3.2)
    axes = figure.subplots()
    _draw_spectrum(axes, spectrum, (0.0, 4.4 * settings.mesh_frequency), HEALTHY, "amplitude")
    _mark_orders(axes, settings)
    _limit_decades(axes)
    dress(axes, plain(title), "frequency, Hz", "amplitude, m/s²")
    return figure


def healthy_faulty_figure(diagnosis: Diagnosis, window: str, bars: Sequence[LineBar] = ()) -> Figure:
    """Faulty over healthy spectra: the orders of the envelope, and the sidebands around f_m and 2 f_m.

    The last argument contains the error bars of the lines of the window.

    Parameters
    ----------
    diagnosis, window : the diagnosis, and one of its windows
    """
    spectra = {
        state: (diagnosis.spectra[state, window], diagnosis.envelopes[state, window]) for state in ("healthy", "faulty")
    }
    title = f"Healthy and faulty, {window}, {LOADS.get(diagnosis.load, diagnosis.load)}"
    figure = comparison_figure(spectra, diagnosis.settings, title, (HEALTHY, FAULTY), window)
    for axes, kind, n in zip(figure.axes, ("envelope", "sideband", "sideband"), (0, 1, 2), strict=False):
        lines = diagnosis.lines.where(window=window, kind=kind, mesh_harmonic=n, detected=1)
        if len(lines):
            axes.plot(lines.frequency, lines.faulty, "v", ms=5, color=FAULTY, label="detected", zorder=4)
        _draw_bars(axes, [bar for bar in bars if (bar.kind == "envelope") == (kind == "envelope")])
    legend(figure.axes[0])
    return figure


def _draw_bars(axes: Axes, bars: Sequence[LineBar]) -> None:
    """Draw the error bars of the visible lines: numerical ones at the line, those of the inputs to the right of it."""
    low, high = axes.get_xlim()
    inside = [bar for bar in bars if low <= bar.frequency <= high]
    for name, colour, shift in (("numerical", NUMERICAL, 0.0), ("inputs", INPUTS, OFFSET * (high - low))):
        shown = [bar for bar in inside if getattr(bar, name) is not None]
        if shown:
            level = np.array([bar.level for bar in shown])
            ends = np.array([[getattr(bar, name).low, getattr(bar, name).high] for bar in shown]).T
            place = [bar.frequency + shift for bar in shown]
            axes.vlines(place, *(level * 10 ** (ends / 20)), color=colour, lw=3.0, zorder=5)


def error_bars_figure(bars: Sequence[LineBar], window: str) -> Figure:
    """Error bars of the lines of a window, dB relative to the level of the run."""
    names = [f"envelope {bar.label}" if bar.kind == "envelope" else bar.label for bar in bars]
    longest = max(map(len, names), default=0)
    figure = fixed_figure(3.6, bottom=0.3 + 0.7 * LETTER * longest)
    axes = figure.subplots()
    places = np.arange(len(bars), dtype=float)
    kinds = ("numerical", "numerical uncertainty", NUMERICAL, -0.12), ("inputs", "uncertain damping", INPUTS, 0.12)
    for name, words, colour, shift in kinds:
        shown = [i for i, bar in enumerate(bars) if getattr(bar, name) is not None]
        if shown:
            ends = [[getattr(bars[i], name).low, getattr(bars[i], name).high] for i in shown]
            axes.vlines(places[shown] + shift, *np.array(ends).T, color=colour, lw=4.0, label=f"{words}, 5 to 95 %")
    axes.axhline(0.0, color=MARK, lw=0.8)
    axes.set_xticks(places, [plain_symbols(name) for name in names], rotation=60, ha="right", fontsize=8)
    dress(axes, f"Window {plain(window)}", "", "change of level, dB")
    legend(axes)
    return figure


def pass_figure(diagnosis: Diagnosis, window: str, spall: PassLines) -> Figure:
    """Healthy and faulty up to the third harmonic of a spall's pass frequency, its lines marked: envelope, spectrum."""
    sides = f", sidebands at {spall.spacing_label}" if spall.spacing else ""
    whole = plain(f"{spall.fault.capitalize()}, {window}{sides} · {diagnosis.settings.sensor}")
    figure = fixed_figure(6.0, title=whole, rows=2, down=0.45)
    lines, end = spall.own(diagnosis.lines.where(window=window)), (HARMONICS + 0.6) * spall.frequency
    for axes, found, title in zip(
        figure.subplots(2, 1, sharex=True), (diagnosis.envelopes, diagnosis.spectra), ("Envelope spectrum", "Spectrum"),
        strict=True,
    ):  # fmt: skip
        for state, colour, thickness in (("healthy", HEALTHY, 2.0), ("faulty", FAULTY, 1.0)):
            span = (0.3 * spall.frequency, min(end, float(found[state, window].frequency[-1])))
            _draw_spectrum(axes, found[state, window], span, colour, state, thickness)
        if found is diagnosis.envelopes and lines.detected.any():
            seen = lines.where(detected=1)
            axes.plot(seen.frequency, seen.faulty, "v", ms=5, color=FAULTY, label="detected", zorder=4)
        _limit_decades(axes)
        _mark(axes, [(f, plain(name) if f == k * spall.frequency else "") for name, k, f in spall.monitored()])
        dress(axes, title, "frequency, Hz" if title == "Spectrum" else "", "amplitude, m/s²")
        legend(axes)
    return figure


def comparison_figure(
    spectra: Spectra,
    settings: DiagnosisSettings,
    title: str,
    colours: Sequence[str] = (FIRST, SECOND),
    window: str | None = None,
) -> Figure:
    """Envelope spectrum to 8 f_r, and the spectrum within 6 f_r of f_m and of 2 f_m, cases over one another.

    Parameters
    ----------
    spectra : of one case or two
    settings : f_r, f_m, the rope modes and the channel
    title : of the figure
    colours : of the cases
    window : window whose rope mode is marked in the envelope, or None
    """
    f_r, f_m = settings.revolution_frequency, settings.mesh_frequency
    whole = f"{plain(title)} · {settings.sensor} ({settings.axis})"
    figure = fixed_figure(8.2, title=whole, rows=2, columns=2)
    panels = figure.subplot_mosaic([["envelope", "envelope"], ["first", "second"]])
    top, left, right = (panels[name] for name in ("envelope", "first", "second"))
    rope = settings.rope_mode.get(window, 0.0) if window else 0.0
    _, first = next(iter(spectra.values()))
    spans = ((0.3 * f_r, 8.4 * f_r), (f_m - 6.4 * f_r, f_m + 6.4 * f_r), (2 * f_m - 6.4 * f_r, 2 * f_m + 6.4 * f_r))
    thicknesses = (2.0, 1.0)  # thin over thick: equal lines show
    for (name, pair), colour, thickness in zip(spectra.items(), colours, thicknesses, strict=False):
        for axes, span in zip((top, left, right), spans, strict=True):
            _draw_spectrum(axes, pair[axes is top], span, colour, name, thickness)
    for axes in (top, left, right):
        _limit_decades(axes)
    _mark(top, [(k * f_r, "fᵣ" if k == 1 else f"{k} fᵣ") for k in range(1, 9)])
    if rope:
        top.axvline(rope, color=ROPE, ls=":", lw=1.6, label=f"rope mode {rope:.2f} Hz")
    for axes, centre, name in ((left, f_m, "fₘ"), (right, 2 * f_m, "2 fₘ")):
        _mark(axes, [(centre + k * f_r, f"{k:+d}" if k else name) for k in range(-4, 5)])
    dress(
        top,
        f"Envelope spectrum, band {first.band_low:.4g} to {first.band_high:.4g} Hz",
        "frequency, Hz",
        "amplitude, m/s²",
    )
    dress(left, "Spectrum around fₘ, sidebands k fᵣ", "frequency, Hz", "amplitude, m/s²")
    dress(right, "Spectrum around 2 fₘ, sidebands k fᵣ", "frequency, Hz", "")
    legend(top)
    return figure


def _draw_spectrum(
    axes: Axes, spectrum: Spectrum, span: tuple[float, float], colour: str, name: str, thickness: float = 1.0
) -> None:
    inside = (spectrum.frequency >= span[0]) & (spectrum.frequency <= span[1])
    axes.semilogy(spectrum.frequency[inside], spectrum.amplitude[inside], color=colour, lw=thickness, label=plain(name))
    axes.yaxis.set_major_formatter(FuncFormatter(_power_of_ten))
    axes.yaxis.set_minor_locator(NullLocator())  # minor ticks of a logarithmic axis take half the time of a figure
    axes.set_xlim(span)


def _power_of_ten(value: float, _: int) -> str:
    """Text such as 10⁻³, which matplotlib would set as a formula."""
    return "10" + str(round(np.log10(value))).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _limit_decades(*panels: Axes) -> None:
    """Limit the axis to `DECADES` below the largest value, with room above for the labels of the markers."""
    drawn = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for axes in panels for line in axes.lines])
    drawn = drawn[drawn > 0]
    if drawn.size:
        top = drawn.max() * 4
        panels[0].set_ylim(max(drawn.min() / 2, top / 10**DECADES), top)  # panels share it


def _mark_orders(axes: Axes, settings: DiagnosisSettings) -> None:
    _mark(axes, [(n * settings.mesh_frequency, "fₘ" if n == 1 else f"{n} fₘ") for n in range(1, 5)])
    _mark(axes, [(settings.revolution_frequency, "fᵣ")], shift=3)


def _mark(axes: Axes, places: Sequence[tuple[float, str]], shift: float = 0.0) -> None:
    """Dashed lines at frequencies (Hz) with their names, moved to the right by `shift` (points)."""
    across = axes.get_xaxis_transform()
    frequencies = [frequency for frequency, _ in places]
    axes.vlines(frequencies, 0.0, 1.0, transform=across, color=MARK, lw=0.6, ls=(0, (4, 3)), zorder=0)
    for frequency, name in places:
        if not name:
            continue
        axes.annotate(
            name,
            (frequency, 1.0),
            xycoords=across,
            xytext=(shift, -3),
            textcoords="offset points",
            ha="left" if shift else "center",
            va="top",
            fontsize=8,
            color=MARK,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.8},
        )
