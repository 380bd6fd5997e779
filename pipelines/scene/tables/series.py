"""Samples over time or speed, given in the scene or as a column of a file, which is checked line by line."""

from __future__ import annotations

import contextlib
import csv
import io
import math
from collections.abc import Iterator, Sequence
from importlib import resources
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Discriminator, Field, Tag

from fem.storage.hdf5_file import blocks_missing
from pipelines.io.errors import InputError, Problem, SceneError
from pipelines.io.shown_text import nearest_name, number_of, shown
from pipelines.io.user_files import read_text, regular_file
from pipelines.scene.tables.scene_table import Number, Table

MOST_BYTES = 200_000_000
HDF5 = (".h5", ".hdf5")


class ColumnTable(Table):
    """A column of a CSV file with a header line, or a dataset of an HDF5 file (.h5, .hdf5)."""

    file: Annotated[str, Field(min_length=1, description="name in the folder of the scene, or a path")]
    column: Annotated[
        str, Field(min_length=1, description="name of the column or dataset; its values have the unit of the key")
    ]


def _kind(value: object) -> str:
    return "values" if isinstance(value, Sequence) and not isinstance(value, str) else "column"


Samples = Annotated[
    Annotated[tuple[Number, ...], Field(min_length=1, max_length=100_000), Tag("values")]
    | Annotated[ColumnTable, Tag("column")],
    Discriminator(_kind),
]


def in_file(given: object) -> bool:
    """Whether samples are a column of a file."""
    return isinstance(given, ColumnTable)


def check_pairs(table: Table, places: str, values: str) -> None:
    """Raise ValueError unless two keys of a table have equal numbers of values in the scene; places must increase."""
    first, second = getattr(table, places), getattr(table, values)
    if in_file(first) or in_file(second):
        return
    if len(first) != len(second):
        raise ValueError(f"{places} has {len(first)} values, {values} has {len(second)}. Set equal numbers of both")
    unit = places.rpartition("_")[2]
    for before, after in zip(first, first[1:], strict=False):
        if after <= before:
            raise ValueError(
                f"{places} must increase strictly, but {after:g} {unit} follows {before:g} {unit}. Correct them"
            )


def pairs(table: Table, places: str, values: str, path: str) -> tuple[np.ndarray, np.ndarray]:
    """Places (n,) and values (n,) of two keys of a table, as written, in the units of their keys.

    Parameters
    ----------
    table : of the scene
    places, values : its keys, e.g. "times_s" and "speeds_rpm"; places increase
    path : of the table in the scene, for messages

    Raises
    ------
    SceneError : no such file or column, a cell that is not a number, places that do not increase, different lengths
    """
    first, line = samples(getattr(table, places), f"{path}.{places}")
    second, _ = samples(getattr(table, values), f"{path}.{values}")
    if len(first) != len(second):
        raise refused(
            f"{path}.{values}", f"has {len(second)} values for {len(first)} of {places}", "Set equal numbers of both"
        )
    wrong = np.flatnonzero(np.diff(first) <= 0)
    if len(wrong):
        i = int(wrong[0]) + 1
        at = "" if line is None else f" (value {i + 1}, about line {line + i})"
        raise refused(
            f"{path}.{places}",
            f"must increase strictly, but {first[i]:g} follows {first[i - 1]:g}{at}",
            "Sort the lines, and delete repeated ones",
        )
    return first, second


def samples(given: tuple[float, ...] | ColumnTable, path: str) -> tuple[np.ndarray, int | None]:
    """The values (n,), and the line of the file that holds the first one; None if they are in the scene.

    Parameters
    ----------
    given : values, or a column of a file
    path : of the key in the scene, for messages

    Raises
    ------
    SceneError : no such file or column, or a cell that is not a number
    """
    if not isinstance(given, ColumnTable):
        return np.array(given, dtype=float), None
    shipped = Path(str(resources.files("pipelines.scene"))) / "shipped" / given.file
    file = Path(given.file)
    file = shipped if shipped.suffix == ".csv" and not file.exists() and shipped.is_file() else file
    with reading(file, given.file, path, MOST_BYTES, "CSV or HDF5"):
        if file.suffix.lower() in HDF5:
            return _dataset(file, given.column, path), None
        return _column(read_text(file, MOST_BYTES), given, path), 2


def _column(text: str, given: ColumnTable, path: str) -> np.ndarray:
    head = text.partition("\n")[0]
    separator = ";" if ";" in head else "\t" if "\t" in head else ","
    rows = csv.reader(io.StringIO(text), delimiter=separator)
    names = [name.strip() for name in next(rows, [])]
    if given.column not in names:
        near = nearest_name(given.column, names)
        hint = f'Did you mean "{near}"?' if near else "Set one of them"
        raise refused(f"{path}.column", f"the file has the columns {', '.join(map(shown, names))}", hint, given.column)
    place, values = names.index(given.column), []
    for row in rows:
        if not row:
            continue
        cell = row[place].strip() if place < len(row) else ""
        values.append(cell_number(cell, rows.line_num, given.column, path, given.file))
    if not values:
        raise refused(f"{path}.file", "the file has no values", "Write values below the header line")
    return np.array(values)


def _dataset(file: Path, name: str, path: str) -> np.ndarray:
    import h5py

    with h5py.File(file, "r") as opened:
        found: Any = opened.get(name)
        if not isinstance(found, h5py.Dataset):
            raise refused(f"{path}.column", f"the file has the datasets {', '.join(opened)}", "Set one of them", name)
        if problem := blocks_missing(found):
            raise refused(f"{path}.column", problem, "Save or copy the file again", name)
        values = np.asarray(found[()], dtype=float).ravel()
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        raise refused(
            f"{path}.column", f"value {bad[0] + 1} of {len(values)} is {values[bad[0]]}", "Correct the file", name
        )
    return values


def cell_number(cell: str, line: int, column: str, path: str, file: str | None = None) -> float:
    """The number in a cell of a file.

    Parameters
    ----------
    cell, line, column : text of the cell, and where it is
    path, file : key of the file in the scene, and name of the file, for messages

    Raises
    ------
    SceneError : it is not a finite number
    """
    value = number_of(cell)
    if not math.isfinite(value):
        what = f"{shown(cell)} is not a number" if cell else "the cell is empty"
        raise refused(
            f"{path}.file", f"line {line}, column {shown(column)}: {what}", "Correct or delete that line", file
        )
    return value


def refused(path: str, message: str, remedy: str, value: str | None = None) -> SceneError:
    """Error for a key of the scene.

    Parameters
    ----------
    path, value : of the key in the scene, and its value
    message, remedy : what is wrong, and how to correct it
    """
    return SceneError("scene", [Problem(path, message, remedy, None if value is None else f'"{value}"')])


@contextlib.contextmanager
def reading(file: Path, name: str, path: str, most_bytes: int, kinds: str) -> Iterator[None]:
    """Turn errors while a file is read into a SceneError.

    Parameters
    ----------
    file, name : its path, and its name in the scene
    path : of the table in the scene, for messages
    most_bytes, kinds : upper bound of its size, and its possible formats

    Raises
    ------
    SceneError : the file does not exist, is not a regular file, is too large, or cannot be read
    """
    try:
        regular_file(file, most_bytes)
        yield
    except FileNotFoundError:
        remedy = "Correct the path; it starts at the folder of the scene"
        raise refused(f"{path}.file", "there is no such file", remedy, name) from None
    except SceneError:
        raise
    except InputError as error:
        raise refused(f"{path}.file", str(error), "") from error
    except Exception as error:  # libraries raise errors of many types
        raise refused(f"{path}.file", f"cannot be read ({error})", f"Set a {kinds} file", name) from error
