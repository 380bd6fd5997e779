"""A matplotlib figure as an SVG element for a page: text stays text, rendered pictures alone are pixels."""

from __future__ import annotations

import hashlib
import html
import io
import re

from matplotlib import rc_context
from matplotlib.figure import Figure

PICTURE_DPI = 110  # of rendered pictures inside a figure; all else consists of lines
FONT = "system-ui, 'Segoe UI', Roboto, 'Liberation Sans', 'DejaVu Sans', sans-serif"
_PIXELS_PER_INCH = 96  # of CSS
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
    for axes in figure.axes:
        formatter = axes.yaxis.get_major_formatter()
        formatter.format_ticks(list(axes.yaxis.get_majorticklocs()))
        if offset := formatter.get_offset():  # a factor such as 1e-6, which covers the title at its own place
            axes.set_ylabel(f"{axes.get_ylabel()} × {offset}")
            axes.yaxis.get_offset_text().set_visible(False)
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
