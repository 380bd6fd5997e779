"""Rows: one small file per run with its values, labels and outcome; a run is done when its row is there.

A row is written after the signals of its run, aside, to the disk, and then moved into place. So what a killed worker
leaves is no row, and the run is simulated again. Two writers of one run write the same row.
"""

from __future__ import annotations

import json
import os
import re
import uuid
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pipelines.datasets.tables import write_parquet
from pipelines.io.errors import InputError

ROWS = "rows"
TABLE = "rows.parquet"
DONE, FAILED = "done", "failed"
_NAME = re.compile(r"(\d+)\.json")


def write_row(folder: Path, run: int, row: Mapping[str, Any], rows: str = ROWS) -> None:
    """Write the row of a run; whole or not at all.

    Parameters
    ----------
    folder : of the campaign
    run : its number
    row : plain values
    rows : folder of the rows

    Raises
    ------
    OSError : it cannot be written
    """
    place = folder / rows
    aside = place / f".{run}-{uuid.uuid4().hex[:12]}.partial"
    try:
        with open(aside, "w", encoding="utf-8") as file:
            json.dump(row, file, allow_nan=False)
            file.flush()
            os.fsync(file.fileno())
        os.replace(aside, row_path(folder, run, rows))
    except BaseException:
        aside.unlink(missing_ok=True)
        raise


def row_path(folder: Path, run: int, rows: str = ROWS) -> Path:
    """The file of the row of a run."""
    return folder / rows / f"{run:06d}.json"


def numbers(folder: Path, rows: str = ROWS) -> set[int]:
    """The runs that have a row."""
    place = folder / rows
    if not place.is_dir():
        return set()
    return {int(found[1]) for name in os.listdir(place) if (found := _NAME.fullmatch(name))}


def read_row(folder: Path, run: int, rows: str = ROWS) -> dict[str, Any]:
    """The row of a run.

    Raises
    ------
    InputError : it is not there or is none
    """
    path = row_path(folder, run, rows)
    try:
        row = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(
            f"{path}: the row cannot be read ({error}). Delete the file and repeat the campaign."
        ) from error
    if not isinstance(row, dict) or row.get("run") != run:
        raise InputError(f"{path}: not the row of run {run}. Delete the file and repeat the campaign.")
    return row


def read_rows(folder: Path, rows: str = ROWS) -> Iterator[dict[str, Any]]:
    """All rows in the order of the runs, one at a time."""
    for run in sorted(numbers(folder, rows)):
        yield read_row(folder, run, rows)


def sweep_rows(folder: Path, rows: str = ROWS) -> None:
    """Remove what writers that were killed left; to be called when nobody writes."""
    for path in (folder / rows).glob(".*.partial"):
        path.unlink(missing_ok=True)


def write_table(folder: Path) -> int:
    """Make the Parquet table of the rows; how many there are. Checksums stay in the rows.

    Raises
    ------
    OSError : it cannot be written
    InputError : a row is damaged
    """
    return write_parquet(folder / TABLE, lambda: map(flat, read_rows(folder)))


def flat(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row as columns of one level: values and labels under their own names."""
    out: dict[str, Any] = {}
    for name, value in row.items():
        if name == "checksums":
            continue
        if isinstance(value, Mapping):
            out |= value
        else:
            out[name] = json.dumps(value) if isinstance(value, list) else value
    return out
