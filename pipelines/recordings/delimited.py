"""Text files of numbers in columns (CSV, TXT): read in blocks of lines, kept outside memory.

Separators are tabulator, semicolon, comma or blanks, the decimal mark is a point or, with any other separator than the
comma, a comma. The first line of which all cells are numbers begins the data; names and units are sought above it.
"""

from __future__ import annotations

import codecs
import csv
import itertools
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipelines.io.errors import InputError
from pipelines.io.shown import shown
from pipelines.recordings.channels import Channel, Contents, distinct, exported_place, name_and_units, of_array

_LINES = 50_000  # read at once
_HEAD = 100  # lines in which the data must begin
_COUNTER = "sample"
_DIALECTS = (("\t", "."), ("\t", ","), (";", "."), (";", ","), (",", "."), (None, "."), (None, ","))


@dataclass(frozen=True, kw_only=True)
class Layout:
    """How a file is written.

    `separator` is None for blanks; `ended` says that one stands at the end of each line, too; `first` is the number of
    the first line of data, from 0.
    """

    separator: str | None
    decimal: str
    ended: bool
    first: int
    names: tuple[str, ...]
    units: tuple[str, ...]


def open_channels(path: Path) -> Contents:
    """The channels of all columns.

    Raises
    ------
    InputError : no numbers, a cell that is none, lines of different lengths, with the line
    """
    encoding = _encoding(path)
    with path.open(encoding=encoding, errors="replace", newline=None) as file:
        head = [line.rstrip("\n") for line in itertools.islice(file, _HEAD)]
    layout = _layout(head, path)
    columns = len(layout.names)
    scratch = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the contents
    try:
        for block in _blocks(path, encoding, layout):
            scratch.write(block.tobytes())
        scratch.flush()
        values = np.memmap(scratch, dtype=float, mode="r").reshape(-1, columns)
        return Contents(channels=tuple(_channels(values, layout)), close=scratch.close)
    except BaseException:
        scratch.close()
        raise


def _channels(values: np.ndarray, layout: Layout) -> Iterator[Channel]:
    for column, (name, units) in enumerate(zip(layout.names, layout.units, strict=True)):
        label = name or (_guessed(values[:1000, column]) if column == 0 else "") or f"channel {column + 1}"
        yield of_array(label, values[:, column], units=units, place=exported_place(label))


def _guessed(start: np.ndarray) -> str:
    """The name of a first column without one: a counter of samples, time if it rises evenly, else ""."""
    steps = np.diff(start)
    if not len(steps) or not np.all(steps > 0.0):
        return ""
    if np.all(steps == 1.0):
        return _COUNTER
    return "time" if np.ptp(steps) <= 0.5 * steps.mean() else ""


def _blocks(path: Path, encoding: str, layout: Layout) -> Iterator[np.ndarray]:
    """The numbers (lines, columns), block by block."""
    with path.open(encoding=encoding, errors="replace", newline=None) as file:
        numbered = ((number, line) for number, line in enumerate(file, 1) if number > layout.first and line.strip())
        while block := list(itertools.islice(numbered, _LINES)):
            lines = [_plain(line, layout) for _, line in block]
            try:
                values = np.loadtxt(lines, delimiter=layout.separator, ndmin=2, comments=None, quotechar='"')
            except ValueError as error:
                raise _damaged(path, block, layout) or InputError(f"{shown(path)}: {error}.") from error
            if values.shape[1] != len(layout.names):
                raise _damaged(path, block, layout) or InputError(
                    f"{shown(path)}: the number of columns changes. Give each line the same number."
                )
            yield values


def _plain(line: str, layout: Layout) -> str:
    """A line without the separator at its end, with decimal points."""
    line = line.rstrip("\r\n ")
    if layout.ended:
        line = line.removesuffix(str(layout.separator))
    return line.replace(",", ".") if layout.decimal == "," else line


def _damaged(path: Path, block: list[tuple[int, str]], layout: Layout) -> InputError | None:
    """What is wrong in the first bad line of a block."""
    for place, (number, line) in enumerate(block):
        cells = _cells(_plain(line, layout), layout.separator)
        if len(cells) != len(layout.names):
            ends = " The file may be cut off." if place == len(block) - 1 else ""
            return InputError(
                f"{shown(path)}: line {number} has {len(cells)} cells, the first line of data {len(layout.names)}."
                f"{ends} Correct or delete that line."
            )
        for cell, name in zip(cells, layout.names, strict=True):
            if not _is_number(cell, "."):
                what = f'"{shown(cell.strip(), 40)}" is not a number' if cell.strip() else "the cell is empty"
                column = f", column {shown(name, 40)}" if name else ""
                remedy = "Correct the cell; a deleted line would leave a gap in time."
                return InputError(f"{shown(path)}: line {number}{column}: {what}. {remedy}")
    return None


def _layout(head: list[str], path: Path) -> Layout:
    """The first way of writing in which a line is all numbers and the line below it has as many cells."""
    for separator, decimal in _DIALECTS:
        rows = [_cells(line, separator) for line in head]
        for number, (line, row) in enumerate(zip(head, rows, strict=True)):
            if separator in ("\t", ";") and separator not in line:
                continue
            cells = _trimmed(row)
            below = next((other for other in rows[number + 1 :] if other), row)
            if cells and len(row) == len(below) and all(_is_number(cell, decimal) for cell in cells):
                if found := _titled(head, number, row, separator, decimal):
                    return found
                break
    if not any(line.strip() for line in head):
        raise InputError(f"{shown(path)}: is empty. Give a file with columns of numbers.")
    raise InputError(
        f"{shown(path)}: none of its first {len(head)} lines holds numbers alone. Give columns of numbers that are "
        "separated by tabulators, semicolons, commas or blanks."
    )


def _titled(head: list[str], first: int, row: list[str], separator: str | None, decimal: str) -> Layout | None:
    """The layout with the titles above the first row; None if a single title says that "0,5" is one number."""
    count = len(_trimmed(row))
    titles = [_trimmed(_cells(line, separator)) for line in head[:first]]
    above = [[cell.strip() for cell in cells] for cells in titles[-2:] if len(cells) == count]
    if separator == "," and first and len(titles[-1]) == 1 and count == 2:
        return None
    if len(above) == 2 and len(titles[-1]) == count:
        names, units = above  # a line of names, a line of units
        pairs = [(name_and_units(name)[0], unit.strip("[]() ")) for name, unit in zip(names, units, strict=True)]
    elif above and len(titles[-1]) == count:
        pairs = [name_and_units(name) for name in above[-1]]
    else:
        pairs = [("", "")] * count
    named = iter(distinct([name for name, _ in pairs if name]))
    return Layout(
        separator=separator,
        decimal=decimal,
        ended=len(row) > count,
        first=first,
        names=tuple(next(named) if name else "" for name, _ in pairs),
        units=tuple(unit for _, unit in pairs),
    )


def _cells(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return line.split()
    return next(csv.reader([line], delimiter=separator), [])


def _trimmed(cells: list[str]) -> list[str]:
    """Without the empty cell behind a separator at the end."""
    return cells[:-1] if len(cells) > 1 and not cells[-1].strip() else cells


def _is_number(cell: str, decimal: str) -> bool:
    try:
        float(cell.strip().replace(",", ".") if decimal == "," else cell)
    except ValueError:
        return False
    return "_" not in cell


def _encoding(path: Path) -> str:
    """UTF-8 or UTF-16 with its mark, else what Western instruments write if the start is no UTF-8."""
    with path.open("rb") as file:
        start = file.read(1 << 16)
    if start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(start)
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig"
