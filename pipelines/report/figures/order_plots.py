"""Figures of run-ups. Every function returns the figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipelines.report.figures.plots import RPM, dress, legend, new_figure
from pipelines.signals.orders.order_spectra import Waterfall

DECIBELS = 70.0  # range of the colour scale
NAMED = 6  # number of orders with a line


def waterfall_figure(found: Waterfall, title: str, units: str, *, top: float | None = None) -> Figure:
    """Amplitude over speed and frequency or order, in colours.

    Parameters
    ----------
    found : the spectra
    title : of the figure
    units : of the signal
    top : highest frequency or order in the figure
    """
    figure = new_figure(5.6)
    axes = figure.subplots()
    _draw(axes, found, units, top)
    axes.ticklabel_format(useOffset=False)
    dress(
        axes,
        title,
        "order of " + found.shaft.replace("_", " ") if found.over == "order" else "frequency, Hz",
        "speed, rpm",
    )
    return figure


def cuts_figure(found: Waterfall, orders: Sequence[float], title: str, units: str) -> Figure:
    """Amplitude along orders over the speed.

    Parameters
    ----------
    found : the spectra
    orders : of the shaft
    title : of the figure
    units : of the signal
    """
    figure = new_figure(4.2)
    axes = figure.subplots()
    rising = np.argsort(found.speed)
    for order in orders:
        axes.semilogy(found.speed[rising] * RPM, found.cut(order)[rising], label=f"order {order:g}", lw=1.2)
    dress(axes, title, "speed, rpm", f"amplitude, {units}")
    legend(axes)
    return figure


def campbell_figure(
    found: Waterfall, natural: Mapping[float, np.ndarray], orders: Sequence[float], title: str, units: str
) -> Figure:
    """Campbell diagram: a waterfall over frequency with lines of natural frequencies and orders.

    Parameters
    ----------
    found : over frequency
    natural : natural frequencies (Hz) of the machine by speed of the shaft (rad/s)
    orders : of the shaft, shown as lines through 0
    title : of the figure
    units : of the signal
    """
    figure = new_figure(6.4)
    axes = figure.subplots()
    top = max((float(values.max()) for values in natural.values() if len(values)), default=float(found.line[-1]))
    _draw(axes, found, units, top)
    for speed, values in natural.items():
        axes.plot(values, np.full(len(values), speed * RPM), "o", ms=3.0, mfc="none", mec="white", mew=0.8)
    ends = np.array([found.speed.min(), found.speed.max()])
    for order in orders[:NAMED]:
        frequencies = order * ends / (2 * np.pi)
        axes.plot(frequencies, ends * RPM, color="white", lw=0.8, ls="--")
        place = min(frequencies[1], 0.97 * top)
        height = ends[1] if frequencies[1] <= top else place * 2 * np.pi / order
        axes.text(place, height * RPM, f" {order:g}", color="white", fontsize=8, va="top")
    axes.set(xlim=(0.0, top), ylim=(0.0, 1.02 * float(ends[1]) * RPM))
    dress(axes, title, "frequency, Hz; circles: natural frequencies, dashed: orders", "speed, rpm")
    return figure


def _draw(axes: Axes, found: Waterfall, units: str, top: float | None) -> None:
    rising = np.argsort(found.speed)
    shown = found.line <= (found.line[-1] if top is None else top)
    level = 20 * np.log10(np.maximum(found.amplitude[rising][:, shown], 1e-30))
    high = float(level[:, 1:].max())
    mesh = axes.pcolormesh(
        found.line[shown],
        found.speed[rising] * RPM,
        level,
        shading="nearest",
        cmap="magma",
        vmin=high - DECIBELS,
        vmax=high,
    )
    axes.figure.colorbar(mesh, ax=axes, label=f"dB re 1 {units}")
