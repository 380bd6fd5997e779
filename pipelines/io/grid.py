"""A table of words: headers and rows of cells, rendered as text, Markdown or HTML."""

from __future__ import annotations

import html
from collections.abc import Callable
from dataclasses import dataclass


class GridError(ValueError):
    """A row does not have one cell per header."""


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Cells as they are shown. Columns whose cells all start like numbers are set to the right."""

    title: str
    headers: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    marked: frozenset[int] = frozenset()  # rows that are set off: detected lines

    def __post_init__(self) -> None:
        for i, row in enumerate(self.rows):
            if len(row) != len(self.headers):
                raise GridError(f"{self.title}: row {i} has {len(row)} cells for {len(self.headers)} headers")

    def numeric(self) -> tuple[bool, ...]:
        """Which columns hold numbers."""
        columns = [[row[i] for row in self.rows if row[i] not in ("", "-")] for i in range(len(self.headers))]
        return tuple(bool(cells) and all(_starts_like_number(cell) for cell in cells) for cells in columns)

    def to_text(self) -> str:
        """Aligned columns for a log or a text file."""
        widths = [max(len(row[i]) for row in (self.headers, *self.rows)) for i in range(len(self.headers))]
        right = self.numeric()

        def line(cells: tuple[str, ...]) -> str:
            padded = (c.rjust(w) if r else c.ljust(w) for c, w, r in zip(cells, widths, right, strict=True))
            return "  ".join(padded).rstrip()

        rule = "  ".join("-" * width for width in widths)
        return "\n".join([self.title, line(self.headers), rule, *(line(row) for row in self.rows)])

    def to_markdown(self) -> str:
        """A Markdown table; rows that are set off are bold."""
        rule = ["---:" if right else "---" for right in self.numeric()]
        lines = [list(self.headers), rule]
        for i, row in enumerate(self.rows):
            lines.append([f"**{cell}**" if i in self.marked and cell else cell for cell in row])
        return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |" for cells in lines)

    def to_html(self, typeset: Callable[[str], str] = html.escape) -> str:
        """A table element; rows that are set off have the class "marked". `typeset` makes HTML of a cell's words."""
        right = self.numeric()
        sides = [' class="number"' if r else "" for r in right]
        head = "".join(f"<th{s}>{typeset(c)}</th>" for c, s in zip(self.headers, sides, strict=True))
        body = []
        for i, row in enumerate(self.rows):
            cells = "".join(f"<td{s}>{typeset(c)}</td>" for c, s in zip(row, sides, strict=True))
            body.append(f'<tr class="marked">{cells}</tr>' if i in self.marked else f"<tr>{cells}</tr>")
        caption = f"<caption>{typeset(self.title)}</caption>" if self.title else ""
        return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{''.join(body)}</tbody></table>"


def _starts_like_number(cell: str) -> bool:
    return cell.lstrip("+-−")[:1].isdigit()
