"""Parquet tables of rows that are too many for memory: the rows are gone through twice, for types and for values."""

from __future__ import annotations

import itertools
import json
import os
import uuid
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

_BATCH = 2000  # rows that are in memory at once

Row = Mapping[str, Any]


def write_parquet(path: Path, rows: Callable[[], Iterable[Row]]) -> int:
    """Write a table, whole or not at all; how many rows it has.

    A column has the type of its values: text if any is text, whole numbers if all are.

    Parameters
    ----------
    path : of the table
    rows : gives all rows anew each time; plain values

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
    aside = path.with_name(f".{path.name}-{uuid.uuid4().hex[:12]}.partial")
    count = 0
    try:
        with pq.ParquetWriter(aside, schema) as writer:
            left = iter(rows())
            while batch := list(itertools.islice(left, _BATCH)):
                columns = [
                    pa.array([cell(row.get(field.name), field.type) for row in batch], field.type) for field in schema
                ]
                writer.write_table(pa.Table.from_arrays(columns, schema=schema))
                count += len(batch)
        os.replace(aside, path)
    finally:
        aside.unlink(missing_ok=True)
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
