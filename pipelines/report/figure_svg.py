"""A matplotlib figure as an SVG element for a page: text stays text, rendered pictures alone are pixels.

Its scales become few artists: matplotlib makes five of every tick, a third of the time of a report.
"""

from __future__ import annotations

import hashlib
import html
import io
import re

import numpy as np
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import FixedLocator

from pipelines.report.figures.plots import GRID

PICTURE_DPI = 110  # of rendered pictures inside a figure; all else consists of lines
FONT = "system-ui, 'Segoe UI', Roboto, 'Liberation Sans', 'DejaVu Sans', sans-serif"
_PIXELS_PER_INCH = 96  # of CSS
_TICK = 3.5 / 72  # inches, length of a tick, and its distance from the number
_LETTERS = ("fontsize", "rotation", "rotation_mode", "horizontalalignment", "verticalalignment", "transform")
_REFERENCE = re.compile(r'(?:url\(#|href="#)([^)"]+)')
_GEOMETRY = re.compile(r' (d|x|y)="([^"]*)"')


def svg(figure: Figure, description: str) -> str:
    """The figure as an element that scales with the page, at most as wide as it was made.

    Its ids are named by its content, so that the figures of one page do not take each other's clips and markers.

    Parameters
    ----------
    figure : of matplotlib
    description : for those who cannot see it
    """

    if figure.get_layout_engine() is None:
        _simplify_scales(figure)
    written = io.StringIO()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "report"}):
        figure.savefig(written, format="svg", dpi=PICTURE_DPI, metadata={"Date": None})
    text = written.getvalue()
    inside = text[text.index(">", text.index("<svg")) + 1 : text.rindex("</svg>")]
    inside = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>|<!--.*?-->|<defs>\s*</defs>", "", inside, flags=re.S)
    inside = _named_by(_short(inside), hashlib.sha256((description + text).encode()).hexdigest()[:8])
    box = re.search(r'viewBox="([^"]*)"', text)
    assert box is not None  # matplotlib always writes one
    width = round(figure.get_figwidth() * _PIXELS_PER_INCH)
    label = html.escape(description, quote=True)
    return f'<svg role="img" aria-label="{label}" viewBox="{box[1]}" style="max-width:{width}px">{inside}</svg>'


def _named_by(text: str, name: str) -> str:
    """Ids that are referred to begin with a name; the others are left out."""
    referenced = set(_REFERENCE.findall(text))
    text = re.sub(r' id="([^"]*)"', lambda m: f' id="{name}-{m[1]}"' if m[1] in referenced else "", text)
    text = text.replace("xlink:href=", "href=")
    return _REFERENCE.sub(lambda m: m[0].replace(f"#{m[1]}", f"#{name}-{m[1]}"), text)


def _short(text: str) -> str:
    """Coordinates to a hundredth of a point, repeated commands once, the page's own fonts."""
    text = _GEOMETRY.sub(lambda m: f' {m[1]}="{_path(m[2])}"', text)
    text = re.sub(r"('DejaVu Sans'|'Bitstream Vera Sans').*?sans-serif", FONT, text)
    return re.sub(r">\s*\n\s*<", "><", text.strip())


def _path(coordinates: str) -> str:
    rounded = re.sub(r"(\.\d\d)\d+", r"\1", coordinates)
    joined = re.sub(r"\s*([A-Za-z])\s*", r"\1", rounded.replace("\n", " ")).strip()
    return re.sub(r"(?<=L)([^A-Za-z]*)((?:L[^A-Za-z]*)+)", lambda m: m[1] + m[2].replace("L", " "), joined)


def _simplify_scales(figure: Figure) -> None:
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
    end = -_TICK * figure.dpi / axes.bbox.size[1 if across else 0]
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
