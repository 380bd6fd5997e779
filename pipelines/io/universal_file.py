"""Universal file format, dataset 58: functions over time as text, written in blocks and read record by record.

A dataset is enclosed in lines "    -1". Eleven records describe the function. Its values follow in columns of fixed
width: 13 characters in single, 20 in double precision. The step of the abscissa has six digits.

References
----------
Universal file dataset 58 (function at nodal DOF), Structural Dynamics Research Laboratory, University of Cincinnati.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import IO, Any

import numpy as np

TIME_RESPONSE = 1
QUANTITIES = {8: "m", 11: "m/s", 12: "m/s2", 13: "N"}  # types of the ordinate that can be written, with their units
_FRAME = "    -1"
_SINGLE, _DOUBLE = "S13", "S20"
_COLUMNS: dict[tuple[int, int], list[tuple[str, str]]] = {  # by type of the data and spacing of the abscissa
    (2, 1): [("y", _SINGLE)],
    (2, 0): [("x", _SINGLE), ("y", _SINGLE)],
    (4, 1): [("y", _DOUBLE)],
    (4, 0): [("x", _SINGLE), ("y", _DOUBLE)],
}
_PER_LINE = 4  # values in double precision


class UniversalFileError(ValueError):
    """The file is not a universal file, or is incomplete."""


@dataclass(frozen=True, kw_only=True)
class Function:
    """Description of a function in a dataset 58: the five lines of text, the point, and the axes.

    `function` is its type, 1 for a time response. `direction` is 1, 2, 3 for +x, +y, +z, negative for the opposite
    directions, 0 for a scalar. `quantity` is the type of the ordinate, 12 for an acceleration. Missing texts are "".
    """

    lines: tuple[str, ...]  # five
    function: int = TIME_RESPONSE
    entity: str = ""
    node: int = 0
    direction: int = 0
    size: int
    start: float  # s
    step: float  # s
    quantity: int = 0
    units: str = ""


@dataclass(frozen=True, eq=False, kw_only=True)
class UniversalFunction:
    """A function with its values (n,); `x` is the abscissa if its step varies."""

    head: Function
    values: np.ndarray
    x: np.ndarray | None


def write_function(file: IO[str], head: Function, blocks: Iterable[np.ndarray]) -> None:
    """Write a function in double precision; `blocks` are its values, in arrays whose sizes are multiples of 4."""
    lines = (*head.lines, *[""] * (5 - len(head.lines)))
    file.write(f"{_FRAME}\n{58:6d}\n")
    file.writelines(f"{line[:80] or 'NONE':<80}\n" for line in lines)
    place = f"{head.entity[:10] or 'NONE':>10}{head.node:10d}{head.direction:4d}"
    file.write(f"{head.function:5d}{0:10d}{0:5d}{0:10d} {place} {'NONE':>10}{0:10d}{0:4d}\n")
    file.write(f"{4:10d}{head.size:10d}{1:10d}{head.start:13.5E}{head.step:13.5E}{0.0:13.5E}\n")
    for kind, label, units in ((17, "time", "s"), (head.quantity, "", head.units), (0, "", ""), (0, "", "")):
        file.write(f"{kind:10d}{0:5d}{0:5d}{0:5d} {label[:20] or 'NONE':<20} {units[:20] or 'NONE':<20}\n")
    for values in blocks:
        whole = len(values) // _PER_LINE * _PER_LINE
        np.savetxt(file, values[:whole].reshape(-1, _PER_LINE), fmt="%20.12E", delimiter="")
        if whole < len(values):
            np.savetxt(file, values[None, whole:], fmt="%20.12E", delimiter="")
    file.write(f"{_FRAME}\n")


def read_functions(file: IO[str]) -> Iterator[UniversalFunction]:
    """All time responses of a file in their order; datasets of other types are skipped.

    Raises
    ------
    UniversalFileError : not a universal file, binary or complex values, or the file ends within a dataset
    """
    lines = (line.rstrip() for line in file)
    for line in lines:
        if not line:
            continue
        if line != _FRAME:
            raise UniversalFileError(f'a dataset begins with the line "{_FRAME}", here it is "{line[:40]}"')
        kind = next(lines, "")
        if kind[:6].strip() == "58" and kind[6:7].lower() == "b":
            raise UniversalFileError("its functions are binary (58b), text is read; save it as ASCII")
        content = _content(lines)
        if kind.strip() == "58":
            yield from _record(content)
        else:
            for _ in content:
                pass


def _content(lines: Iterator[str]) -> Iterator[str]:
    """The lines of a dataset up to its end."""
    for line in lines:
        if line == _FRAME:
            return
        yield line
    raise UniversalFileError("it ends within a dataset")


def _record(lines: Iterator[str]) -> Iterator[UniversalFunction]:
    head = list(islice(lines, 11))
    if len(head) < 11:
        raise UniversalFileError("a dataset 58 ends within its eleven head records")
    try:
        function, spacing, data_type, found = _head(head)
    except ValueError as error:
        raise UniversalFileError(f"the head of a dataset 58 cannot be read ({error})") from error
    text = "".join(lines)
    if function != TIME_RESPONSE:
        return
    columns = _COLUMNS.get((data_type, spacing))
    if columns is None:
        raise UniversalFileError(f"the values of {found.lines[0]!r} are complex; give signals over time")
    row = np.dtype(columns)
    raw = text.encode("ascii", errors="replace")
    rows = np.frombuffer(raw, row, count=len(raw) // row.itemsize)
    if len(rows) != found.size or len(raw) % row.itemsize:
        raise UniversalFileError(f"{found.lines[0]!r} states {found.size} values and has {len(rows)}")
    try:
        values = {name: rows[name].astype(float) for name, _ in columns}
    except ValueError as error:
        raise UniversalFileError(f"the values of {found.lines[0]!r} are not all numbers ({error})") from error
    yield UniversalFunction(head=found, values=values["y"], x=values.get("x"))


def _head(lines: list[str]) -> tuple[int, int, int, Function]:
    """Type of the function, spacing, type of the data, and the other facts of the eleven head records."""
    place, form, ordinate = (line.ljust(80) for line in (lines[5], lines[6], lines[8]))
    function, data_type, spacing = int(place[:5]), int(form[:10]), int(form[20:30])
    facts: dict[str, Any] = {
        "entity": _text(place[31:41]),
        "node": int(place[41:51]),
        "direction": int(place[51:55]),
        "size": int(form[10:20]),
        "start": float(form[30:43]),
        "step": float(form[43:56]),
        "quantity": int(ordinate[:10]),
        "units": _text(ordinate[47:67]),
    }
    return function, spacing, data_type, Function(lines=tuple(map(_text, lines[:5])), function=function, **facts)


def _text(text: str) -> str:
    return "" if text.strip() in ("NONE", "None") else text.strip()
