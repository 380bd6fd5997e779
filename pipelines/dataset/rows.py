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

from pipelines.border.errors import InputError

ROWS = "rows"
TABLE = "rows.parquet"
DONE, FAILED = "done", "failed"
_NAME = re.compile(r"(\d+)\.json")
_BATCH = 2000  # rows that are in memory at once


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
        raise InputError(f"{path}: no row ({error}). Remove it; the campaign makes it again.") from error
    if not isinstance(row, dict) or row.get("run") != run:
        raise InputError(f"{path}: not the row of run {run}. Remove it; the campaign makes it again.")
    return row


def read_rows(folder: Path, rows: str = ROWS) -> Iterator[dict[str, Any]]:
    """All rows in the order of the runs, one at a time."""
    for run in sorted(numbers(folder, rows)):
        yield read_row(folder, run, rows)


def sweep_rows(folder: Path, rows: str = ROWS) -> None:
    """Remove what writers that were killed left; to be called when nobody writes."""
    for path in (folder / rows).glob(".*.partial"):
        path.unlink(missing_ok=True)


def write_table(folder: Path, rows: str = ROWS, table: str = TABLE) -> int:
    """Make the Parquet table of the rows; how many there are.

    A column has the type of its values: text if any is text, whole numbers if all are. Checksums stay in the rows.

    Raises
    ------
    OSError : it cannot be written
    InputError : a row is damaged
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    fields: dict[str, Any] = {}
    for row in read_rows(folder, rows):
        for name, value in _columns(row).items():
            fields[name] = _wider(fields.get(name, pa.null()), value)
    schema = pa.schema([pa.field(name, kind) for name, kind in fields.items()])
    path = folder / table
    aside = path.with_name(f".{table}-{uuid.uuid4().hex[:12]}.partial")
    count = 0
    try:
        with pq.ParquetWriter(aside, schema) as writer:
            for batch in _batches(read_rows(folder, rows)):
                columns = [
                    pa.array([_cell(_columns(row).get(field.name), field.type) for row in batch], field.type)
                    for field in schema
                ]
                writer.write_table(pa.Table.from_arrays(columns, schema=schema))
                count += len(batch)
        os.replace(aside, path)
    finally:
        aside.unlink(missing_ok=True)
    return count


def _columns(row: Mapping[str, Any]) -> dict[str, Any]:
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


def _batches(rows: Iterator[dict[str, Any]]) -> Iterator[list[dict[str, Any]]]:
    batch: list[dict[str, Any]] = []
    for row in rows:
        batch.append(row)
        if len(batch) == _BATCH:
            yield batch
            batch = []
    if batch:
        yield batch


def _wider(kind: Any, value: Any) -> Any:
    """The type that holds a column so far and one more value."""
    import pyarrow as pa

    if value is None or kind == pa.string():
        return kind
    if isinstance(value, str):
        return pa.string()
    own = pa.bool_() if isinstance(value, bool) else pa.int64() if isinstance(value, int) else pa.float64()
    if kind in (pa.null(), own):
        return own
    return pa.string() if pa.bool_() in (kind, own) else pa.float64()


def _cell(value: Any, kind: Any) -> Any:
    import pyarrow as pa

    if value is None:
        return None
    if kind == pa.string():
        return value if isinstance(value, str) else json.dumps(value)
    return float(value) if kind == pa.float64() else value
