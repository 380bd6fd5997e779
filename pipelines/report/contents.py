"""Tables of values in a report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pipelines.io.grid import Grid


def grid(title: str, rows: Sequence[Mapping[str, Any]]) -> Grid:
    """A table from rows of named cells; a cell that a row lacks stays empty."""
    headers = tuple(dict.fromkeys(name for row in rows for name in row))
    return Grid(title=title, headers=headers, rows=tuple(tuple(cell(row.get(h, "")) for h in headers) for row in rows))


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
