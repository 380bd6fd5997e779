"""Figures of signals and spectra. Every function returns the figure; showing and saving belong to the caller.

Figures are made with matplotlib's object interface: no display, no global state, no style that leaks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from pipelines.lines import LOADS
from pipelines.spectrum import Spectrum

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

    from pipelines.diagnosis import Diagnosis, DiagnosisSettings

FAULTY, HEALTHY = "#c23b22", "#2a6f97"
FIRST, SECOND = "#2a6f97", "#e08e0b"
MARK, ROPE = "#6b6b6b", "#7a5195"
WIDTH = 10.0  # inches
RPM = 30 / np.pi
DECADES = 5.0  # a spectrum is shown down to this far below its top


@dataclass(frozen=True, eq=False, kw_only=True)
class StiffnessPlot:
    """Stiffness over one wheel's passage: cycle (mesh cycles), k in N/m; `missing` with the tooth gone, or None."""

    title: str
    cycle: np.ndarray
    healthy: np.ndarray
    missing: np.ndarray | None = None
    missing_cycle: np.ndarray | None = None  # where it differs from `cycle`


@dataclass(frozen=True, eq=False, kw_only=True)
class Trace:
    """One case in a comparison of spectra: a name, its spectrum and its envelope spectrum."""

    name: str
    spectrum: Spectrum
    envelope: Spectrum


def new_figure(height: float, width: float = WIDTH) -> Figure:
    """An empty figure (inches) whose parts arrange themselves."""
    return Figure(figsize=(width, height), layout="constrained")


def stiffness_figure(curves: Sequence[StiffnessPlot]) -> Figure:
    """Stiffness curves, one panel per gear stage, healthy and with the missing tooth."""
    figure = new_figure(2.0 + 1.9 * len(curves))
    for curve, axes in zip(curves, np.atleast_1d(figure.subplots(len(curves), 1)), strict=True):
        draw_stiffness(axes, curve)
    figure.suptitle("Mesh stiffness along the transverse line of action")
    return figure


def draw_stiffness(axes: Axes, curve: StiffnessPlot) -> None:
    """One stiffness curve into the axes, in N/µm over the mesh cycle."""
    axes.plot(curve.cycle, curve.healthy / 1e6, color=HEALTHY, label="healthy")
    if curve.missing is not None:
        cycle = curve.cycle if curve.missing_cycle is None else curve.missing_cycle
        axes.plot(cycle, curve.missing / 1e6, color=FAULTY, label="missing tooth")
    axes.set_ylim(0, None)
    axes.margins(x=0)
    _dress(axes, curve.title, "mesh cycle", "stiffness, N/µm")
    _legend(axes)


def drive_figure(run: xarray.Dataset, windows: Mapping[str, tuple[float, float]]) -> Figure:
    """Speeds of the motors and the input shaft, and the rope force where there is a rope; windows shaded."""
    motors: tuple[tuple[str, dict[str, Any]], ...] = (
        ("motor 1", {"lw": 3.2, "alpha": 0.45, "color": FIRST}),
        ("motor 2", {"ls": "--", "color": SECOND}),
    )
    has_rope = "rope_force" in run
    panels = np.atleast_1d(new_figure(5.6 if has_rope else 3.2).subplots(1 + has_rope, 1, sharex=True))
    figure = panels[0].figure
    time = run.time.values
    speeds = run.motor_speed.transpose("motor", "time").values if "motor_speed" in run else ()
    for (name, style), speed in zip(motors, speeds, strict=False):
        panels[0].plot(time, speed * RPM, label=name, **style)
    if "shaft_speed" in run:
        panels[0].plot(time, run.shaft_speed.isel(shaft=0).values * RPM, label="input shaft", color="black", lw=0.8)
    _dress(panels[0], "Speed of motors and input shaft", "" if has_rope else "time, s", "speed, rpm")
    if has_rope:
        panels[1].plot(time, run.rope_force.values / 1e3, color=FIRST, lw=0.9)
        _dress(panels[1], "Rope force", "time, s", "force, kN")
    for panel in panels:
        panel.margins(x=0, y=0.16)
        _shade(panel, windows)
    _legend(panels[0])
    return figure


def waveform_figure(
    runs: Mapping[str, xarray.Dataset], sensor: str, axis: str, windows: Mapping[str, tuple[float, float]]
) -> Figure:
    """Acceleration over the whole run and, beside it, a tenth of a second from the middle of the first window."""
    figure = new_figure(1.0 + 1.9 * len(runs))
    grid = figure.subplots(len(runs), 2, sharex="col", sharey="col", squeeze=False, width_ratios=[3, 2])
    middle = float(np.mean(next(iter(windows.values())))) if windows else None
    for (name, run), (whole, detail) in zip(runs.items(), grid, strict=True):
        time, signal = run.time.values, run.acceleration.sel(sensor=sensor, axis=axis).values
        colour = HEALTHY if name.startswith("healthy") else FAULTY
        start = time[-1] / 2 if middle is None else middle
        near = (time >= start) & (time <= start + 0.1)
        whole.plot(time, signal, color=colour, lw=0.4)
        detail.plot(time[near], signal[near], color=colour, lw=0.9)
        last = name == list(runs)[-1]
        _dress(whole, f"{sensor} {axis}, {name}", "time, s" if last else "", "acceleration, m/s²")
        _dress(detail, f"0.1 s from {start:g} s, {name}", "time, s" if last else "", "")
        whole.margins(x=0, y=0.16)
        _shade(whole, windows)
        detail.margins(x=0)
    return figure


def spectrum_figure(diagnosis: Diagnosis, window: str) -> Figure:
    """Faulty over healthy spectrum up to four mesh orders, with f_r, the mesh orders and their sidebands marked."""
    settings = diagnosis.settings
    figure = new_figure(5.4)
    panels = figure.subplots(2, 1, sharex=True, sharey=True)
    end = 4.4 * settings.mesh_frequency
    for axes, state, colour in zip(panels, ("faulty", "healthy"), (FAULTY, HEALTHY), strict=True):
        spectrum = diagnosis.spectra[state, window]
        _draw_spectrum(axes, spectrum, (0.0, end), colour, state)
        for order in range(1, 5):
            _mark(axes, order * settings.mesh_frequency, "$f_m$" if order == 1 else f"{order} $f_m$")
        _mark(axes, settings.revolution_frequency, "$f_r$", shift=3)
        lines = diagnosis.lines.where(window=window, kind="sideband")
        axes.plot(
            lines.frequency,
            getattr(lines, state),
            "o",
            ms=3.5,
            mfc="none",
            mec="black",
            mew=0.7,
            label="sidebands k $f_r$",
        )
        _dress(axes, f"{state.capitalize()}", "frequency, Hz" if state == "healthy" else "", "amplitude, m/s²")
        _legend(axes)
    _common_decades(panels)
    figure.suptitle(
        f"Spectrum at {settings.sensor} ({settings.axis}), {window}, {LOADS.get(diagnosis.load, diagnosis.load)}"
    )
    return figure


def healthy_faulty_figure(diagnosis: Diagnosis, window: str) -> Figure:
    """Faulty over healthy in one axes each: the envelope's orders and the sidebands around f_m and 2 f_m."""
    traces = [
        Trace(name=state, spectrum=diagnosis.spectra[state, window], envelope=diagnosis.envelopes[state, window])
        for state in ("healthy", "faulty")
    ]
    title = f"Healthy and faulty, {window}, {LOADS.get(diagnosis.load, diagnosis.load)}"
    figure = comparison_figure(traces, diagnosis.settings, title, (HEALTHY, FAULTY), window)
    for axes, kind, n in zip(figure.axes, ("envelope", "sideband", "sideband"), (0, 1, 2), strict=False):
        lines = diagnosis.lines.where(window=window, kind=kind, mesh_harmonic=n, stands=1)
        if len(lines):
            axes.plot(lines.frequency, lines.faulty, "v", ms=5, color=FAULTY, label="line stands", zorder=4)
    _legend(figure.axes[0])
    return figure


def comparison_figure(
    traces: Sequence[Trace],
    settings: DiagnosisSettings,
    title: str,
    colours: Sequence[str] = (FIRST, SECOND),
    window: str | None = None,
) -> Figure:
    """Envelope spectrum to 8 f_r, and the spectrum within 6 f_r of f_m and of 2 f_m, cases over one another.

    The rope mode of `window` is marked in the envelope where it is given.
    """
    f_r, f_m = settings.revolution_frequency, settings.mesh_frequency
    figure = new_figure(8.2)
    panels = figure.subplot_mosaic([["envelope", "envelope"], ["first", "second"]])
    top, left, right = (panels[name] for name in ("envelope", "first", "second"))
    rope = settings.rope_mode.get(window, 0.0) if window else 0.0
    low, high = traces[0].envelope.band_low, traces[0].envelope.band_high
    for trace, colour in zip(traces, colours, strict=False):
        _draw_spectrum(top, trace.envelope, (0.0, 8.4 * f_r), colour, trace.name, skip_zero=True)
        _draw_spectrum(left, trace.spectrum, (f_m - 6.4 * f_r, f_m + 6.4 * f_r), colour, trace.name)
        _draw_spectrum(right, trace.spectrum, (2 * f_m - 6.4 * f_r, 2 * f_m + 6.4 * f_r), colour, trace.name)
    for axes in (top, left, right):
        _limit_decades(axes)
    for k in range(1, 9):
        _mark(top, k * f_r, "$f_r$" if k == 1 else f"{k} $f_r$")
    if rope:
        top.axvline(rope, color=ROPE, ls=":", lw=1.6, label=f"rope mode {rope:.2f} Hz")
    for axes, centre, name in ((left, f_m, "$f_m$"), (right, 2 * f_m, "2 $f_m$")):
        _mark(axes, centre, name)
        for k in (-4, -3, -2, -1, 1, 2, 3, 4):
            _mark(axes, centre + k * f_r, f"{k:+d}")
    _dress(top, f"Envelope spectrum, band {low:.4g} to {high:.4g} Hz", "frequency, Hz", "amplitude, m/s²")
    _dress(left, "Spectrum around $f_m$, sidebands k $f_r$", "frequency, Hz", "amplitude, m/s²")
    _dress(right, "Spectrum around 2 $f_m$, sidebands k $f_r$", "frequency, Hz", "")
    _legend(top)
    figure.suptitle(f"{title} · {settings.sensor} ({settings.axis})")
    return figure


def bars_figure(title: str, names: Sequence[str], values: Sequence[float], unit: str) -> Figure:
    """Horizontal bars with their numbers, the first at the top: seconds per stage, energy per part."""
    figure = new_figure(1.2 + 0.32 * len(names))
    axes = figure.subplots()
    bars = axes.barh(list(names), list(values), color=FIRST)
    axes.bar_label(bars, labels=[f"{value:.3g}" for value in values], padding=4)
    axes.invert_yaxis()
    axes.margins(x=0.12)
    _dress(axes, title, unit, "")
    axes.grid(visible=False, axis="y")
    return figure


def _draw_spectrum(
    axes: Axes, spectrum: Spectrum, span: tuple[float, float], colour: str, name: str, skip_zero: bool = False
) -> None:
    inside = (spectrum.frequency >= span[0]) & (spectrum.frequency <= span[1])
    if skip_zero:
        inside &= spectrum.frequency > 0.3 * spectrum.revolutions * spectrum.resolution
    axes.semilogy(spectrum.frequency[inside], spectrum.amplitude[inside], color=colour, lw=1.0, label=name)
    axes.yaxis.set_minor_locator(NullLocator())  # minor ticks of a log axis take half the time of a figure
    axes.set_xlim(span)


def _legend(axes: Axes) -> None:
    """Legend on the level of the title, to the right: it never hides a curve."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.99), ncols=5, frameon=False, fontsize=9, borderaxespad=0.1)


def _limit_decades(axes: Axes) -> None:
    """Show at most `DECADES` below the largest value, with room above for the labels of the markers."""
    drawn = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in axes.lines])
    drawn = drawn[drawn > 0]
    if drawn.size:
        top = drawn.max() * 4
        axes.set_ylim(max(drawn.min() / 2, top / 10**DECADES), top)


def _common_decades(panels: Sequence[Axes]) -> None:
    for axes in panels:
        _limit_decades(axes)
    low, high = min(a.get_ylim()[0] for a in panels), max(a.get_ylim()[1] for a in panels)
    for axes in panels:
        axes.set_ylim(max(low, high / 10**DECADES), high)


def _mark(axes: Axes, frequency: float, name: str, shift: float = 0.0) -> None:
    axes.axvline(frequency, color=MARK, lw=0.6, ls=(0, (4, 3)), zorder=0)
    axes.annotate(
        name,
        (frequency, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(shift, -3),
        textcoords="offset points",
        ha="left" if shift else "center",
        va="top",
        fontsize=8,
        color=MARK,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.8},
    )


def _shade(axes: Axes, windows: Mapping[str, tuple[float, float]]) -> None:
    for name, (start, end) in windows.items():
        axes.axvspan(start, end, color="black", alpha=0.05, lw=0)
        axes.annotate(
            name,
            ((start + end) / 2, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, -3),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=8,
            color=MARK,
        )


def _dress(axes: Axes, title: str, x: str, y: str) -> None:
    axes.set_title(title, fontsize=10, loc="left")
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(visible=True, color="#dddddd", lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
