"""The two figures of the first screen: a time-synchronous average and an envelope spectrum. Each function returns one.

They are half a screen wide, so that their letters are as large as those of the text, on a telephone too.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipelines.report.figures.colours import FAULTY, HEALTHY
from pipelines.report.figures.plots import MARK, dress, fixed_figure, legend, plain, plain_symbols

SIZE = (2.9, 5.0)  # height and width, inches
LETTERS = 8.5  # points
STRONGEST = "#f3c9a5"
DIFFERENCE = "#5c3d7a"


def average_figure(
    place: np.ndarray,
    value: np.ndarray,
    reference: np.ndarray | None = None,
    *,
    across: str,
    marked: tuple[float, float] | None = None,
    marked_name: str = "",
) -> Figure:
    """The averages over one turn of this run and its control, and their difference; the marked tooth is shaded.

    Parameters
    ----------
    place : (n,), rising, deg or teeth
    value, reference : (n,), m/s2; time-synchronous averages of the run and of the healthy control, None without one
    across : what `place` is, with its unit: "tooth of the stage 1 wheel in mesh"
    marked, marked_name : places of the tooth that is a candidate, None without one, and words for it
    """
    panels = 1 if reference is None else 2
    figure = fixed_figure(*SIZE, rows=panels, down=0.3)
    first, *others = np.atleast_1d(figure.subplots(panels, 1, sharex=True))
    _draw(first, place, value, reference)
    first.set_xlim(place[0], place[-1])
    for axes in others:
        axes.plot(place, value - reference, color=DIFFERENCE, lw=0.9)
        dress(axes, "Difference: this run minus healthy", plain(across), "m/s²", letters=LETTERS)
    dress(first, "Time-synchronous average", "" if others else plain(across), "m/s²", letters=LETTERS)
    for axes in (first, *others):
        if marked is not None:
            axes.axvspan(*marked, color=STRONGEST, lw=0, zorder=0)
        axes.margins(y=0.15)
    if marked is not None:
        middle = sum(marked) / 2
        beyond = middle > place.mean()
        first.annotate(
            plain(marked_name) + " " if beyond else " " + plain(marked_name),
            (marked[0 if beyond else 1], 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, -3),
            textcoords="offset points",
            ha="right" if beyond else "left",
            va="top",
            fontsize=LETTERS,
            color=FAULTY,
            fontweight="bold",
        )
    return figure


def envelope_figure(
    line: np.ndarray,
    amplitude: np.ndarray,
    reference: np.ndarray | None = None,
    *,
    marked: Sequence[tuple[float, str]],
    band: str,
) -> Figure:
    """The envelope spectrum and that of the healthy recordings, the lines of the verdict named.

    Parameters
    ----------
    line : (n,), Hz
    amplitude, reference : (n,), m/s2; of the run and of the healthy control, None without one
    marked : places (Hz) and labels of the lines that the verdict reads
    band : words for the demodulated band
    """
    figure = fixed_figure(*SIZE)
    axes = figure.subplots()
    _draw(axes, line, amplitude, reference)
    axes.set_xlim(line[0], line[-1])
    top = float(max(np.max(amplitude), 0.0 if reference is None else np.max(reference)))
    axes.set_ylim(0.0, 1.18 * top if top > 0.0 else 1.0)
    for place, name in marked:
        axes.axvline(place, color=MARK, lw=0.6, ls=(0, (4, 3)), zorder=0)
        axes.annotate(
            plain_symbols(name),
            (place, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, -2),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=LETTERS,
            color=MARK,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
        )
    dress(axes, f"Envelope, {plain(band)}", "frequency, Hz", "amplitude, m/s²", letters=LETTERS)
    return figure


def _draw(axes: Axes, across: np.ndarray, value: np.ndarray, reference: np.ndarray | None) -> None:
    if reference is None:
        axes.plot(across, value, color=HEALTHY, lw=0.9)
        return
    axes.plot(across, reference, color=HEALTHY, lw=1.0, label="healthy")
    axes.plot(across, value, color=FAULTY, lw=1.0, label="this run")
    legend(axes, LETTERS)
