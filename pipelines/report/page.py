"""One self-contained HTML page: headings, paragraphs, tables and inlined pictures, nothing from outside."""

from __future__ import annotations

import base64
import html
import io
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipelines.border.grid import Grid

STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", "DejaVu Sans", sans-serif;
  color: #1c2329; background: #fff; margin: 0; }
main { max-width: 1060px; margin: 0 auto; padding: 2.2rem 1.6rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.25; margin: 0 0 .2rem; }
h2 { font-size: 1.25rem; margin: 2.6rem 0 .7rem; padding-top: .9rem; border-top: 1px solid #d9dee3; }
h3 { font-size: 1rem; margin: 1.5rem 0 .4rem; }
p, li { max-width: 50rem; }
.lead { color: #56616b; margin: 0 0 1.4rem; }
.answer { background: #f2f5f8; border-left: 5px solid #2a6f97; padding: .9rem 1.2rem; margin: 1rem 0; }
.answer.positive { border-color: #c23b22; }
.answer p { margin: .5rem 0; max-width: none; }
.answer p:first-child { font-size: 1.15rem; font-weight: 600; }
.missing { color: #56616b; background: #fbf7ec; border-left: 5px solid #e0b84f; padding: .6rem 1rem; }
nav { font-size: .9rem; color: #56616b; margin: 1.2rem 0; }
nav a { color: #2a6f97; text-decoration: none; margin-right: 1rem; white-space: nowrap; }
figure { margin: 1rem 0 1.6rem; }
figure img { max-width: 100%; height: auto; display: block; }
figcaption { font-size: .88rem; color: #56616b; margin-top: .3rem; max-width: 50rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .88rem; margin: .6rem 0 1.4rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; font-weight: 600; padding: .2rem 0 .4rem; }
th, td { padding: .26rem .7rem; text-align: left; border-bottom: 1px solid #e6eaee; vertical-align: top; }
th { border-bottom: 2px solid #b9c2cb; font-weight: 600; vertical-align: bottom; }
sub { line-height: 0; font-size: .75em; }
td:first-child { white-space: nowrap; }
td.number { text-align: right; white-space: nowrap; }
th.number { text-align: right; max-width: 6rem; }
tr.marked td { background: #fbe6e0; }
tr.marked td:first-child { box-shadow: inset 4px 0 #c23b22; }
details summary { cursor: pointer; color: #2a6f97; margin: .6rem 0; }
pre { font-size: .8rem; background: #f6f8fa; padding: .8rem; white-space: pre-wrap; word-break: break-word; }
@media print { h2 { break-after: avoid; } figure, tr { break-inside: avoid; } nav { display: none; } }
"""


SYMBOL = re.compile(r"(?<![A-Za-z])([A-Za-z])_([a-z])(?![A-Za-z0-9_])")


def typeset(text: str) -> str:
    """Text for the page, symbols such as f_r with their subscript."""
    return SYMBOL.sub(r"<i>\1</i><sub>\2</sub>", html.escape(text))


def document(title: str, body: Sequence[str]) -> str:
    """The whole page."""
    content = "\n".join(body)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{html.escape(title)}</title><style>{STYLE}</style></head>\n"
        f"<body><main>\n{content}\n</main></body></html>\n"
    )


def heading(text: str, level: int = 2) -> str:
    """A heading; those of level 2 can be linked to by `anchor`."""
    mark = f' id="{anchor(text)}"' if level == 2 else ""
    return f"<h{level}{mark}>{html.escape(text)}</h{level}>"


def anchor(text: str) -> str:
    """Name of a section within the page."""
    return "-".join("".join(c if c.isalnum() else " " for c in text.lower()).split())


def contents(titles: Sequence[str]) -> str:
    """Links to the sections."""
    return "<nav>" + " ".join(f'<a href="#{anchor(t)}">{html.escape(t)}</a>' for t in titles) + "</nav>"


def paragraph(text: str, style: str = "") -> str:
    """A paragraph, in a named style."""
    mark = f' class="{style}"' if style else ""
    return f"<p{mark}>{typeset(text)}</p>"


def answer(sentences: Sequence[str], positive: bool) -> str:
    """The answer box: the first sentence is set large."""
    style = "answer positive" if positive else "answer"
    return f'<div class="{style}">' + "".join(paragraph(s) for s in sentences) + "</div>"


def table(grid: Grid) -> str:
    """A table that scrolls sideways where the screen is narrow."""
    return f'<div class="wide">{grid.to_html(typeset)}</div>'


def folded(summary: str, inside: str) -> str:
    """Content that opens on a click."""
    return f"<details><summary>{html.escape(summary)}</summary>{inside}</details>"


def preformatted(text: str) -> str:
    """Text as it is."""
    return f"<pre>{html.escape(text)}</pre>"


def picture(figure: Figure, caption: str, dpi: int = 115) -> str:
    """A figure as an inlined PNG, with its caption as alternative text."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi)
    data = base64.b64encode(buffer.getvalue()).decode("ascii")
    text = html.escape(caption, quote=True)
    image = f'<img alt="{text}" src="data:image/png;base64,{data}">'
    return f"<figure>{image}<figcaption>{typeset(caption)}</figcaption></figure>"
