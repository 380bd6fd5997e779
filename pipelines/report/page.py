"""One self-contained HTML page: headings, paragraphs, tables and inlined pictures, nothing from outside."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from importlib.resources import files

from matplotlib.figure import Figure

from pipelines.io.text_table import Grid
from pipelines.report.figure_svg import svg

WIDEST = 10  # columns of a table that a sheet of paper holds

_COMMAND = re.compile(r"`(.+?)`|(gearcase [a-z]+ --[a-z-]+ \d+)")
SYMBOL = re.compile(r"(?<![A-Za-z])([A-Za-z])_([a-z])(?![A-Za-z0-9_])")


def typeset(text: str) -> str:
    """Text for the page, symbols such as f_r with their subscript, commands and `code` without a line break."""
    return _COMMAND.sub(r"<code>\1\2</code>", SYMBOL.sub(r"<i>\1</i><sub>\2</sub>", html.escape(text)))


def asset(name: str) -> str:
    """A style sheet or script that is put into the page."""
    return files("pipelines.report").joinpath("assets", name).read_text(encoding="utf-8")


def document(title: str, body: Sequence[str]) -> str:
    """The whole page."""
    content = "\n".join(body)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{html.escape(title)}</title><style>{asset('report.css')}</style></head>\n"
        f"<body><main>\n{content}\n</main>\n<script>{asset('folding.js')}</script></body></html>\n"
    )


def heading(text: str, level: int = 2) -> str:
    """A heading."""
    return f"<h{level}>{html.escape(text)}</h{level}>"


def section(title: str, parts: Sequence[str], *, opened: bool = False) -> str:
    """A part of the page with a heading, which a click on it opens and closes."""
    state = " open" if opened else ""
    return (
        f'<details class="section" id="{anchor(title)}"{state}><summary>{heading(title)}</summary>\n'
        + "\n".join(parts)
        + "\n</details>"
    )


def anchor(text: str) -> str:
    """Name of a section within the page."""
    return "-".join("".join(c if c.isalnum() else " " for c in text.lower()).split())


def paragraph(text: str, style: str = "") -> str:
    """A paragraph, in a named style."""
    mark = f' class="{style}"' if style else ""
    return f"<p{mark}>{typeset(text)}</p>"


def note(text: str) -> str:
    """The explanation of a table."""
    return paragraph(text, "lead")


def table(grid: Grid) -> str:
    """A table that scrolls sideways where the screen is narrow; one with many columns becomes several, one below
    another, each with the first column."""
    return "".join(f'<div class="wide">{part.to_html(typeset)}</div>' for part in _parts(grid))


def _parts(grid: Grid) -> list[Grid]:
    count = len(grid.headers)
    if count <= WIDEST:
        return [grid]
    pieces = -(-(count - 1) // (WIDEST - 1))
    each = -(-(count - 1) // pieces)
    columns = [[0, *range(first, min(first + each, count))] for first in range(1, count, each)]
    return [
        Grid(
            title=grid.title,
            headers=tuple(grid.headers[i] for i in chosen),
            rows=tuple(tuple(row[i] for i in chosen) for row in grid.rows),
            marked=grid.marked,
        )
        for chosen in columns
    ]


def folded(summary: str, inside: str) -> str:
    """Content that opens on a click."""
    return f"<details><summary>{html.escape(summary)}</summary>{inside}</details>"


def picture(figure: Figure, caption: str, style: str = "") -> str:
    """A figure with its caption, which is also its alternative text."""
    mark = f' class="{style}"' if style else ""
    return f"<figure{mark}><div>{svg(figure, caption)}</div><figcaption>{typeset(caption)}</figcaption></figure>"
