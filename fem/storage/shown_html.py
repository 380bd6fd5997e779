"""Tables and small plots as HTML for a notebook: plain elements with escaped texts, without dependencies.

A notebook displays the result of `_repr_html_` of an object.
"""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

COLOURS = ("#1f77b4", "#d62728", "#2ca02c", "#9467bd")
_WIDTH, _HEIGHT = 420, 150  # px, of the axes of a plot
_LEFT, _TOP, _BELOW = 70, 8, 36  # px around them


def table(caption: str, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table as HTML; numbers have five digits, and None is a dash.

    Parameters
    ----------
    caption : title above the table
    head : names of the columns with their units
    rows : values of all columns
    """
    heads = "".join(f"<th>{_cell(name)}</th>" for name in head)
    body = "".join(f"<tr>{''.join(f'<td>{_cell(value)}</td>' for value in row)}</tr>" for row in rows)
    return f"<table><caption>{_cell(caption)}</caption><thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table>"


def number(value: float) -> str:
    """A number with five digits, without negative zero."""
    return f"{value + 0.0:.5g}"


def curves(across: str, x: np.ndarray, upwards: str, values_of: Mapping[str, np.ndarray]) -> str:
    """A small plot of curves over x as SVG.

    Parameters
    ----------
    across, upwards : names of the axes with their units
    x : (n,), ascending
    values_of : values (n,) of each curve by name; values that are not finite are omitted
    """
    lines = {name: np.asarray(values, float) for name, values in values_of.items()}
    finite = np.concatenate([values[np.isfinite(values)] for values in lines.values()])
    if not len(finite) or not np.isfinite(x).all() or x[-1] <= x[0]:
        return ""
    low, high = min(0.0, float(finite.min())), max(0.0, float(finite.max()))
    high = high if high > low else low + 1.0
    parts = [f'<rect x="{_LEFT}" y="{_TOP}" width="{_WIDTH}" height="{_HEIGHT}" fill="none" stroke="#999"/>']
    for count, (name, values) in enumerate(lines.items()):
        colour = COLOURS[count % len(COLOURS)]
        place, value = _outline(_LEFT + _WIDTH * (x - x[0]) / (x[-1] - x[0]), values)
        height = _TOP + _HEIGHT * (high - value) / (high - low)
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(place, height, strict=True))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}"/>')
        parts.append(_words(_LEFT + _WIDTH + 6, _TOP + 12 + 14 * count, name, "start", colour))
    bottom = _TOP + _HEIGHT
    parts += [_words(_LEFT - 4, _TOP + 8, number(high), "end"), _words(_LEFT - 4, bottom, number(low), "end")]
    parts += [_words(_LEFT, bottom + 14, number(x[0])), _words(_LEFT + _WIDTH, bottom + 14, number(x[-1]), "end")]
    parts += [_words(_LEFT + _WIDTH / 2, bottom + 14, across, "middle"), _words(_LEFT, bottom + 30, upwards)]
    size = f'width="{_LEFT + _WIDTH + 130}" height="{bottom + _BELOW}"'
    return f'<svg {size} font-size="11" font-family="sans-serif">{"".join(parts)}</svg>'


def _outline(place: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The finite points of a curve; with more than two a pixel, the lowest and highest of each, to show all peaks."""
    known = np.isfinite(values)
    place, values = place[known], values[known]
    if len(place) <= 2 * _WIDTH:
        return place, values
    parts = np.array_split(np.arange(len(place)), _WIDTH)
    kept = np.array([sorted((part[values[part].argmin()], part[values[part].argmax()])) for part in parts]).ravel()
    return place[kept], values[kept]


def _words(x: float, y: float, text: str, anchor: str = "start", colour: str = "currentColor") -> str:
    return f'<text x="{x}" y="{y}" text-anchor="{anchor}" fill="{colour}">{html.escape(text)}</text>'


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, float | np.floating):
        return number(float(value)) if math.isfinite(value) else str(value)
    return html.escape(str(value))
