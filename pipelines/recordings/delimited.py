"""Text files of numbers in columns (CSV, TXT, LVM): read in blocks of lines into a temporary file.

Separators are tabulator, semicolon, comma or blanks; the decimal mark is a point or, unless the separator is a
comma, a comma. The first line whose cells are all numbers begins the data; names and units are searched above it.
If there is none, columns may also contain time stamps (date and time, or hh:mm:ss) or text.
"""

from __future__ import annotations

import codecs
import contextlib
import csv
import itertools
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.recordings.recording_channels import (
    DATE,
    RecordedChannel,
    RecordedContents,
    date_of,
    distinct,
    exported_place,
    name_and_units,
    of_array,
)

_LINES = 50_000  # read at once
_HEAD = 100  # lines within which the data must begin
_COUNTER = "sample"
_STAMP = re.compile(rf"(?:({DATE})[T ])?(\d\d?):(\d\d):(\d\d(?:[.,]\d+)?)(?:Z|[+-]\d\d:?\d\d)?")
_REMARKS = ("#", "%")  # first characters of comment lines
NUMBER, STAMP, TEXT = "number", "stamp", "text"  # kinds of columns
_DIALECTS = (("\t", "."), ("\t", ","), (";", "."), (";", ","), (",", "."), (None, "."), (None, ","))


@dataclass(frozen=True, kw_only=True)
class ColumnLayout:
    """Layout of a file: separator, decimal mark, titles.

    `separator` is None for blanks; `ended` is true if one also ends each line; `first` is the number of the first line
    of data, from 0; `kinds` are the kinds of the columns, `rate` (Hz) is that of the header, if any.
    """

    separator: str | None
    decimal: str
    ended: bool
    first: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    kinds: tuple[str, ...]
    rate: float | None = None


def open_channels(path: Path, text: Path | None = None) -> RecordedContents:
    """Channels of all columns.

    Parameters
    ----------
    path : of the file
    text : file with its content as text, if `path` has another format

    Raises
    ------
    InputError : no numbers, a cell that is none, lines of different lengths, with the line
    """
    text = text or path
    encoding = _encoding(text)
    with text.open(encoding=encoding, errors="replace", newline=None) as file:
        head = [line.rstrip("\n") for line in itertools.islice(file, _HEAD)]
    layout = _layout(head, path)
    with contextlib.ExitStack() as opened:
        scratch = opened.enter_context(tempfile.TemporaryFile())
        for block in _blocks(path, text, encoding, layout):
            scratch.write(block.tobytes())
        scratch.flush()
        values = np.memmap(scratch, dtype=float, mode="r").reshape(-1, len(layout.names))
        channels, above = tuple(_channels(values, layout)), "\n".join(head[: layout.first + 1])
        return RecordedContents(channels=channels, close=opened.pop_all().close, texts=above)


def _channels(values: np.ndarray, layout: ColumnLayout) -> Iterator[RecordedChannel]:
    for column, (name, units, kind) in enumerate(zip(layout.names, layout.units, layout.kinds, strict=True)):
        label = name or (_guessed(values[:1000, column]) if column == 0 else "") or f"channel {column + 1}"
        if kind == TEXT:
            yield of_array(label, np.zeros(len(values), "U1"))
        else:
            facts = {"units": "s", "stamps": True} if kind == STAMP else {"units": units, "rate": layout.rate}
            yield of_array(label, values[:, column], place=exported_place(label), **facts)


def _guessed(start: np.ndarray) -> str:
    """Name of a first column without a title: counter of samples, time if it increases evenly, else ""."""
    steps = np.diff(start)
    if not len(steps) or not np.all(steps > 0.0):
        return ""
    if np.all(steps == 1.0):
        return _COUNTER
    return "time" if np.ptp(steps) <= 0.5 * steps.mean() else ""


def _blocks(path: Path, text: Path, encoding: str, layout: ColumnLayout) -> Iterator[np.ndarray]:
    """Numbers (lines, columns), block by block: seconds of time stamps, NaN for text."""
    read: dict[str, Callable[[str], float]] = {STAMP: _seconds(), TEXT: lambda _: float("nan")}
    converters: dict[Any, Any] = {column: read[kind] for column, kind in enumerate(layout.kinds) if kind != NUMBER}
    with text.open(encoding=encoding, errors="replace", newline=None) as file:
        numbered = _data_lines(file, layout)
        while block := list(itertools.islice(numbered, _LINES)):
            lines = [_plain(line, layout) for _, line in block]
            try:
                values = np.loadtxt(
                    lines, delimiter=layout.separator, ndmin=2, comments=None, quotechar='"', converters=converters
                )
            except ValueError as error:
                what = str(error).partition(" at row")[0]  # of the block, not of the file
                raise _damaged(path, block, layout) or InputError(f"{shown(path)}: {what}. Correct it.") from error
            if values.shape[1] != len(layout.names):
                raise _damaged(path, block, layout) or InputError(
                    f"{shown(path)}: the number of columns changes. Give each line the same number."
                )
            yield values


def _data_lines(file: Iterable[str], layout: ColumnLayout) -> Iterator[tuple[int, str]]:
    """Numbers (from 1) and lines of data, without comments, and without lines at the end that have no number."""
    held: list[tuple[int, str]] = []
    for number, line in enumerate(file, 1):
        if number <= layout.first or not line.strip() or line.startswith(_REMARKS):
            continue
        held.append((number, line))
        if re.search(r"\d", line) or any(_is_number(cell, ".") for cell in _cells(line, layout.separator)):
            yield from held
            held.clear()


def _seconds() -> Callable[[str], float]:
    """Function that converts time stamps to seconds since the first one."""
    first: list[tuple[int, float]] = []

    def seconds(cell: str) -> float:
        found = _STAMP.fullmatch(cell.strip())
        if found is None:
            raise ValueError(f"{cell} is no time stamp")
        day = date_of(found[1]).toordinal() if found[1] else 0
        time = 60.0 * (60 * int(found[2]) + int(found[3])) + float(found[4].replace(",", "."))
        if not first:
            first.append((day, time))
        return 86400.0 * (day - first[0][0]) + (time - first[0][1])

    return seconds


def _plain(line: str, layout: ColumnLayout) -> str:
    """A line without the separator at its end, with decimal points."""
    line = line.rstrip("\r\n ")
    if layout.ended:
        line = line.removesuffix(str(layout.separator))
    return line.replace(",", ".") if layout.decimal == "," else line


def _damaged(path: Path, block: list[tuple[int, str]], layout: ColumnLayout) -> InputError | None:
    """Error of the first bad line of a block."""
    for place, (number, line) in enumerate(block):
        cells = _cells(_plain(line, layout), layout.separator)
        if len(cells) != len(layout.names):
            ends = " The file may be cut off." if place == len(block) - 1 else ""
            return InputError(
                f"{shown(path)}: line {number} has {len(cells)} cells, but the first line of data has "
                f"{len(layout.names)}.{ends} Correct or delete that line."
            )
        for cell, name, kind in zip(cells, layout.names, layout.kinds, strict=True):
            if kind != TEXT and _kind_of(cell, ".") != kind:
                wanted = "a number" if kind == NUMBER else "a time stamp"
                what = f'"{shown(cell.strip(), 40)}" is not {wanted}' if cell.strip() else "the cell is empty"
                column = f", column {shown(name, 40)}" if name else ""
                remedy = "Correct the cell; a deleted line would leave a gap in time."
                return InputError(f"{shown(path)}: line {number}{column}: {what}. {remedy}")
    return None


def _layout(head: list[str], path: Path) -> ColumnLayout:
    """First layout for which a line is all numbers and the next line has as many cells.

    Without one, that for which all lines to the end of the head have numbers, time stamps and text in the same columns.
    """
    for mixed, (separator, decimal) in itertools.product((False, True), _DIALECTS):
        rows = [_cells(line, separator) for line in head]
        for number, (line, row) in enumerate(zip(head, rows, strict=True)):
            if ("\t" in line) if separator is None else (separator != "," and separator not in line):
                continue
            kinds = _kinds(row, decimal)
            below = [other for other in rows[number + 1 :] if other]
            if mixed:
                same = bool(below) and all(_kinds(other, decimal) == kinds for other in below)
            else:
                same = len(row) == len(below[0] if below else row)
            if kinds and same and (NUMBER in kinds if mixed else set(kinds) == {NUMBER}):
                if found := _titled(head, number, row, separator, decimal, kinds):
                    return found
                break
    if not any(line.strip() for line in head):
        raise InputError(f"{shown(path)}: is empty. Give a file with columns of numbers.")
    where = f"none of its first {len(head)} lines" if len(head) > 1 else "no line"
    raise InputError(
        f"{shown(path)}: {where} holds numbers alone. Give columns of numbers that are separated by tabulators, "
        "semicolons, commas or blanks."
    )


def _titled(
    head: list[str], first: int, row: list[str], separator: str | None, decimal: str, kinds: tuple[str, ...]
) -> ColumnLayout | None:
    """The layout with the titles above the first row; None if a single title shows that "0,5" is one number.

    One title more than columns is that of comments at the ends of lines, as LabVIEW writes them.
    """
    count = len(kinds)
    laid = [_cells(line, separator) for line in head[:first]]
    titles = [
        *map(_trimmed, laid[:-1]),
        *(one if len(one) in (count, count + 1) else _trimmed(one) for one in laid[-1:]),
    ]
    above = [[cell.strip() for cell in cells[:count]] for cells in titles[-2:] if len(cells) in (count, count + 1)]
    if separator == "," and first and len(titles[-1]) == 1 and count == 2:
        return None
    last = bool(titles) and len(titles[-1]) in (count, count + 1)
    if len(above) == 2 and last:
        names, units = above  # a line of names, a line of units
        pairs = [(name_and_units(name)[0], unit.strip("[]() ")) for name, unit in zip(names, units, strict=True)]
    elif above and last:
        pairs = [name_and_units(name) for name in above[-1]]
    else:
        pairs = [("", "")] * count
    settings = {cells[0]: cells[1:] for cells in titles if cells}
    labels = settings.get("Y_Unit_Label", [])
    if labels and len(labels) < count:
        pairs = [*pairs[:1], *((name, label) for (name, _), label in zip(pairs[1:], labels, strict=False))]
    step = (settings.get("Delta_X") or ["0"])[0].replace(",", ".")
    named = iter(distinct([name for name, _ in pairs if name]))
    return ColumnLayout(
        separator=separator,
        decimal=decimal,
        ended=len(row) > count,
        first=first,
        names=tuple(next(named) if name else "" for name, _ in pairs),
        units=tuple(unit for _, unit in pairs),
        kinds=kinds,
        rate=1.0 / float(step) if _is_number(step, ".") and float(step) > 0.0 else None,
    )


def _kinds(row: list[str], decimal: str) -> tuple[str, ...]:
    return tuple(_kind_of(cell, decimal) for cell in _trimmed(row))


def _kind_of(cell: str, decimal: str) -> str:
    return NUMBER if _is_number(cell, decimal) else STAMP if _STAMP.fullmatch(cell.strip()) else TEXT


def _cells(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return line.split()
    return next(csv.reader([line], delimiter=separator), [])


def _trimmed(cells: list[str]) -> list[str]:
    """Cells without the empty one after a separator at the end."""
    return cells[:-1] if len(cells) > 1 and not cells[-1].strip() else cells


def _is_number(cell: str, decimal: str) -> bool:
    try:
        float(cell.strip().replace(",", ".") if decimal == "," else cell)
    except ValueError:
        return False
    return cell.isascii() and "_" not in cell


def _encoding(path: Path) -> str:
    """UTF-8 or UTF-16 with a byte order mark; cp1252, usual for Western instruments, if the start is no UTF-8."""
    with path.open("rb") as file:
        start = file.read(1 << 16)
    if start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(start)
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig"
