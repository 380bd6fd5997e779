"""Values over time or speed: written in the scene, or a column of a file of measurements."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

from pydantic import Discriminator, Field, Tag

from pipelines.scene.tables.base import Number, Table


class ColumnTable(Table):
    """One column of a CSV file with a line of names, or one dataset of an HDF5 file (.h5, .hdf5)."""

    file: Annotated[str, Field(min_length=1, description="beside the scene, or a path")]
    column: Annotated[str, Field(min_length=1, description="name of the column or dataset; the key says its unit")]


def _kind(value: object) -> str:
    return "values" if isinstance(value, Sequence) and not isinstance(value, str) else "column"


Samples = Annotated[
    Annotated[tuple[Number, ...], Field(min_length=1, max_length=100_000), Tag("values")]
    | Annotated[ColumnTable, Tag("column")],
    Discriminator(_kind),
]


def check_pairs(table: Table, places: str, values: str) -> None:
    """Raise ValueError unless two keys of a table hold pairs, as far as the scene alone tells; places must rise."""
    first, second = getattr(table, places), getattr(table, values)
    if isinstance(first, ColumnTable) or isinstance(second, ColumnTable):
        return
    if len(first) != len(second):
        raise ValueError(f"{places} has {len(first)} values, {values} has {len(second)}")
    unit = places.rpartition("_")[2]
    for before, after in zip(first, first[1:], strict=False):
        if after <= before:
            raise ValueError(f"{places} must rise strictly: {after} {unit} follows {before} {unit}")
