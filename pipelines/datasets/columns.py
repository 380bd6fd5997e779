"""The rows of a data set as columns over all its runs, also while it grows: a run without a row has the status ""."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipelines.datasets.rows import ROWS, TABLE, row_columns

_SHORT = 64  # characters; longer texts do not take the place of the longest one each


def read_columns(folder: Path, runs: int) -> dict[str, np.ndarray]:
    """Every column of the rows but the number of the run, (runs,) each.

    Numbers are float64 with NaN where there is none, or int64 where all runs have one; texts are "" where there is
    none; flags are numbers, 0 and 1. What is both in one column is text.

    Parameters
    ----------
    folder : of the data set
    runs : how many it will have

    Raises
    ------
    InputError : a row is damaged
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:  # the table, if it was made after the last row came or went
        fresh = (folder / TABLE).stat().st_mtime_ns > (folder / ROWS).stat().st_mtime_ns
        found = pq.read_table(folder / TABLE).to_pydict() if fresh else row_columns(folder)
    except (OSError, pa.ArrowException):
        found = row_columns(folder)
    place = {run: number for number, run in enumerate(found.pop("run", []))}
    placed = {
        name: [values[place[run]] if run in place else None for run in range(runs)] for name, values in found.items()
    }
    return {name: as_array(values) for name, values in ({"status": [None] * runs} | placed).items()}


def as_array(values: Sequence[Any]) -> np.ndarray:
    """Plain values, None among them, as one array; see `read_columns`."""
    given = [value for value in values if value is not None]
    if any(isinstance(value, str) for value in given) or not given:
        texts = ["" if value is None else str(value) for value in values]
        short = max(map(len, texts), default=0) <= _SHORT
        return np.array(texts, dtype=np.str_ if short else object)
    if len(given) == len(values) and all(isinstance(value, int) for value in given):
        return np.array(values, dtype=np.int64)
    return np.array([np.nan if value is None else value for value in values], dtype=float)


def counted(columns: Mapping[str, np.ndarray], name: str, none: str = "not done") -> dict[str, int]:
    """How many runs have each value of a text column, the most frequent first."""
    texts = sorted(str(value) or none for value in columns.get(name, ()))
    return dict(Counter(texts).most_common())
