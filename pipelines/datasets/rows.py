"""Rows: one small file per run with its values, labels and outcome; a run is done when its row is there.

A row is written after the signals of its run, aside, to the disk, and then moved into place. So what a killed worker
leaves is no row, and the run is simulated again. Two writers of one run write the same row.
"""

from __future__ import annotations

import itertools
import json
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pipelines.io.errors import InputError
from pipelines.io.user_files import whole_file

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
    with whole_file(row_path(folder, run, rows)) as aside, open(aside, "w", encoding="utf-8") as file:
        json.dump(row, file, allow_nan=False)
        file.flush()
        os.fsync(file.fileno())


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
    for pattern in (".*.json", ".*.partial"):  # the second is that of earlier versions
        for path in (folder / rows).glob(pattern):
            path.unlink(missing_ok=True)


def write_table(folder: Path) -> None:
    """Make the Parquet table of the rows, whole or not at all. Checksums stay in the rows.

    Raises
    ------
    OSError : it cannot be written
    InputError : a row is damaged
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    with whole_file(folder / TABLE) as aside:
        pq.write_table(pa.table(row_columns(folder)), aside)


def row_columns(folder: Path) -> dict[str, list[Any]]:
    """Every column of the rows, in the order of the runs; None where a row has no value."""
    rows = [flat(row) for row in read_rows(folder)]
    return {name: [row.get(name) for row in rows] for name in dict.fromkeys(itertools.chain(*rows))}


def flat(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row as columns of one level: values and labels under their own names."""
    out: dict[str, Any] = {}
    for name, value in row.items():
        if isinstance(value, Mapping):
            out |= {} if name == "checksums" else value
        else:
            out[name] = json.dumps(value) if isinstance(value, list) else value
    return out
