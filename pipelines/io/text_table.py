"""A table of words: headers and rows of cells, rendered as text, Markdown or HTML."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

WIDTH = 100  # characters of a line of a table on the terminal


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Cells as they are shown, one per header. Columns whose cells all start like numbers are set to the right."""

    title: str
    headers: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    marked: frozenset[int] = frozenset()  # rows that are set off: detected lines

    def numeric(self) -> tuple[bool, ...]:
        """Which columns hold numbers."""
        columns = [[row[i] for row in self.rows if row[i] not in ("", "-")] for i in range(len(self.headers))]
        return tuple(bool(cells) and all(cell.lstrip("+-−")[:1].isdigit() for cell in cells) for cells in columns)

    def to_text(self, width: int | None = None) -> str:
        """Aligned columns for a log or a text file. Those beyond a width follow below, after the first column again."""
        widths = [max(len(row[i]) for row in (self.headers, *self.rows)) for i in range(len(self.headers))]
        right = self.numeric()
        parts = [[0] if widths else []]
        for column in range(1, len(widths)):
            if width and sum(widths[i] + 2 for i in parts[-1]) + widths[column] > width and parts[-1] != [0]:
                parts.append([0])
            parts[-1].append(column)

        def line(cells: Sequence[str], part: Sequence[int]) -> str:
            padded = (cells[i].rjust(widths[i]) if right[i] else cells[i].ljust(widths[i]) for i in part)
            return "  ".join(padded).rstrip()

        rule = ["-" * width for width in widths]
        shown = ("\n".join(line(cells, part) for cells in (self.headers, rule, *self.rows)) for part in parts)
        return self.title + "\n" + "\n\n".join(shown)

    def to_markdown(self) -> str:
        """A Markdown table; rows that are set off are bold."""
        lines = [list(self.headers), ["---:" if right else "---" for right in self.numeric()]]
        for i, row in enumerate(self.rows):
            lines.append([f"**{cell}**" if i in self.marked and cell else cell for cell in row])
        return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |" for cells in lines)

    def to_html(self, typeset: Callable[[str], str] = html.escape) -> str:
        """A table element; rows that are set off have the class "marked". `typeset` makes HTML of a cell's words."""
        sides = [' class="number"' if right else "" for right in self.numeric()]
        head = "".join(f"<th{s}>{typeset(c)}</th>" for c, s in zip(self.headers, sides, strict=True))
        body = []
        for i, row in enumerate(self.rows):
            cells = "".join(f"<td{s}>{typeset(c)}</td>" for c, s in zip(row, sides, strict=True))
            body.append(f'<tr class="marked">{cells}</tr>' if i in self.marked else f"<tr>{cells}</tr>")
        caption = f"<caption>{typeset(self.title)}</caption>" if self.title else ""
        return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{''.join(body)}</tbody></table>"


def grid(title: str, rows: Iterable[Mapping[str, Any]], marked: frozenset[int] = frozenset()) -> Grid:
    """A table from rows of named cells; a cell that a row lacks stays empty.

    Parameters
    ----------
    title : above the table
    rows : cells by the head of their column
    marked : numbers of the rows that are emphasised, from 0
    """
    rows = list(rows)
    headers = tuple(dict.fromkeys(name for row in rows for name in row))
    cells = tuple(tuple(cell(row.get(head, "")) for head in headers) for row in rows)
    return Grid(title=title, headers=headers, rows=cells, marked=marked)


def turned(table: Grid, named: Sequence[str]) -> Grid:
    """A transposed table: a row for each quantity, a column for each row, headed by the columns `named`."""
    at = [table.headers.index(name) for name in named]
    quantities = [i for i in range(len(table.headers)) if i not in at]
    headers = [" ".join(f"{name} {row[i]}" if row[i].isdigit() else row[i] for name, i in zip(named, at, strict=True))
               for row in table.rows]  # fmt: skip
    rows = tuple((table.headers[i], *(row[i] for row in table.rows)) for i in quantities)
    return Grid(title=table.title, headers=("", *headers), rows=rows)


def cell(value: Any) -> str:
    """A value as text: floats with four significant digits, lists joined, "" for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, (list, tuple)):
        return ", ".join(cell(v) for v in value)
    return str(value)
