"""Scales of a figure as few artists: matplotlib makes five of every tick, a third of the time of a report."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import FixedLocator

from pipelines.report.figures.plots import GRID

TICK = 3.5 / 72  # inches, length of a tick, and its distance from the number
_LETTERS = ("fontsize", "rotation", "rotation_mode", "horizontalalignment", "verticalalignment", "transform")


def simplify_scales(figure: Figure) -> None:
    """Draw grid, ticks, numbers and labels of a finished figure with fixed margins; scales of words stay."""
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if axes.axison and axis.get_visible() and not isinstance(axis.get_major_locator(), FixedLocator):
                _simplify(figure, axes, axis)


def _simplify(figure: Figure, axes: Axes, axis: Axis) -> None:
    across, shown = axis is axes.xaxis, axis.get_tick_params()
    formatter = axis.get_major_formatter()
    low, high = sorted(axis.get_view_interval())
    slack = 1e-9 * (high - low)
    places = np.asarray(axis.get_majorticklocs())
    places = places[(places >= low - slack) & (places <= high + slack)]
    end = -TICK * figure.dpi / axes.bbox.size[1 if across else 0]
    transform = axes.get_xaxis_transform() if across else axes.get_yaxis_transform()
    if shown.get("gridOn"):
        grid = LineCollection(_lines(places, 1.0, across), colors=GRID, linewidths=0.6, zorder=0.5, transform=transform)
        axes.add_artist(grid)
    ticks = LineCollection(_lines(places, end, across), colors="black", linewidths=0.8, transform=transform)
    found: list[Artist] = [ticks]
    if shown.get("labelbottom" if across else "labelleft", True):
        style = {"fontsize": shown.get("labelsize", 10.0), "ha": "center" if across else "right"}
        style["va"] = "top" if across else "center_baseline"
        for place, number in zip(places, formatter.format_ticks(places.tolist()), strict=True):
            found.append(Text(*_point(place, 2 * end, across), number, transform=transform, **style))
    label = axis.get_label()
    words = " × ".join(filter(None, (label.get_text(), formatter.get_offset())))  # m/s² × 1e−6
    if words:
        style = {name: getattr(label, f"get_{name}")() for name in _LETTERS}
        found.append(Text(*label.get_position(), words, **style))
    for artist in found:
        figure.add_artist(artist, clip=False)
    axis.set_visible(False)


def _lines(places: np.ndarray, end: float, across: bool) -> list[list[tuple[float, float]]]:
    """From the axes at every place to an end in its height or width."""
    return [[_point(place, 0.0, across), _point(place, end, across)] for place in places]


def _point(place: float, beside: float, across: bool) -> tuple[float, float]:
    return (place, beside) if across else (beside, place)
