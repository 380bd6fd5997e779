"""Rows: one small file per run with its values, labels and outcome; a run is done when its row is there.

A row is written after the signals of its run, aside, to the disk, and then moved into place. So what a killed worker
leaves is no row, and the run is simulated again. Two writers of one run write the same row. The
rows of a table may be too many for memory: they are read twice, for types and for values.
"""

from __future__ import annotations

import itertools
import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipelines.io.errors import InputError
from pipelines.io.user_files import whole_file

ROWS = "rows"
TABLE = "rows.parquet"
DONE, FAILED = "done", "failed"
_BATCH = 2000  # rows that are in memory at once
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


@dataclass(frozen=True, kw_only=True)
class RowJob:
    """A row to be computed from the stored signals of a run.

    `rows` is its folder in the data set. `made_of` is what it depends on, as JSON holds it: with anything else it is
    computed again. `computed` returns its content in the process of a worker.
    """

    folder: Path  # of the data set
    run: int
    rows: str
    made_of: Mapping[str, Any]
    computed: Callable[[], Mapping[str, Any]]

    def is_stored(self) -> bool:
        """True if the row is there and made in this way."""
        try:
            return read_row(self.folder, self.run, self.rows).get("made_of") == self.made_of
        except InputError:
            return False

    def write(self) -> None:
        """Compute the row and write it."""
        row = {"run": self.run, "made_of": self.made_of, **self.computed()}
        write_row(self.folder, self.run, row, self.rows)


def compute_rows(
    jobs: Iterable[RowJob], executor: Executor, on_progress: Callable[[int, int], None] = lambda done, total: None
) -> int:
    """Compute the rows that are not stored; how many. It can be stopped at any moment and goes on from there.

    Parameters
    ----------
    jobs : all rows
    executor : of the work
    on_progress : called with how many of how many are done

    Raises
    ------
    OSError : a row cannot be written
    """
    left, places = [], set()
    for job in jobs:
        places.add((job.folder, job.rows))
        if not job.is_stored():
            left.append(job)
    for folder, rows in places:
        (folder / rows).mkdir(parents=True, exist_ok=True)
    for count, _ in enumerate(executor.map(RowJob.write, left), 1):
        on_progress(count, len(left))
    for folder, rows in places:
        sweep_rows(folder, rows)
    return len(left)


def write_parquet(path: Path, rows: Callable[[], Iterable[Mapping[str, Any]]]) -> int:
    """Write a table, whole or not at all; how many rows it has.

    A column has the type of its values: text if any is text, whole numbers if all are.

    Parameters
    ----------
    path : of the table
    rows : gives all rows each time that it is called; plain values

    Raises
    ------
    OSError : it cannot be written
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    fields: dict[str, Any] = {}
    for row in rows():
        for name, value in row.items():
            fields[name] = _wider(fields.get(name, pa.null()), value)
    schema = pa.schema([pa.field(name, kind) for name, kind in fields.items()])
    count = 0
    with whole_file(path) as aside, pq.ParquetWriter(aside, schema) as writer:
        left = iter(rows())
        while batch := list(itertools.islice(left, _BATCH)):
            columns = [
                pa.array([cell(row.get(field.name), field.type) for row in batch], field.type) for field in schema
            ]
            writer.write_table(pa.Table.from_arrays(columns, schema=schema))
            count += len(batch)
    return count


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


def cell(value: Any, kind: Any) -> Any:
    """A plain value as a column of a type of Arrow holds it."""
    import pyarrow as pa

    if value is None:
        return None
    if kind == pa.string():
        return value if isinstance(value, str) else json.dumps(value)
    return float(value) if kind == pa.float64() else value
