"""What every table of a scene is made of: strict numbers, refused unknown keys, values in SI."""

from __future__ import annotations

import types
import typing
from collections import Counter
from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from fem.options import UNITS, in_si, key_suffix

# as written: text is no number, true is not 1
Number = Annotated[float, Field(strict=True)]
Whole = Annotated[int, Field(strict=True)]
Flag = Annotated[bool, Field(strict=True)]
Positive = Annotated[Number, Field(gt=0)]
SUFFIXES = {key_suffix(unit): unit for unit in UNITS}
Window = Annotated[tuple[Number, Number], Field(description="start and end of the window")]


class Table(BaseModel):
    """Base of all tables: unknown keys, NaN and infinity are refused, values cannot be edited."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)

    @property
    def si(self) -> SIValues:
        """Values of keys that end in a unit that is not SI, by key without unit: `si.length` of length_mm, in m."""
        return SIValues(self)


class SIValues:
    """Values of a table in SI."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def __getattr__(self, name: str) -> Any:
        for suffix, unit in SUFFIXES.items():
            if f"{name}_{suffix}" in type(self._table).model_fields:
                return in_si(getattr(self._table, f"{name}_{suffix}"), unit)
        raise AttributeError(f"{type(self._table).__name__} has no key {name} with a unit that is not SI")


def repeated_names(key: str, items: Iterable[Any], remedy: str) -> list[str]:
    """Problems of names that occur several times among the items of a key."""
    counts = Counter(one.name for one in items)
    return [f"{key}: the name {name} occurs {n} times. {remedy}" for name, n in sorted(counts.items()) if n > 1]


def tables(annotation: object) -> tuple[type[BaseModel], ...]:
    """The table classes inside a type: itself, the members of a union, the items of a tuple."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return (annotation,)
    return tuple(one for argument in typing.get_args(annotation) for one in tables(argument))


def is_list(annotation: Any) -> bool:
    """Whether a type is a list of tables."""
    origin = typing.get_origin(annotation)
    if origin in (typing.Union, types.UnionType, Annotated):
        return any(is_list(one) for one in typing.get_args(annotation))
    return origin is tuple and bool(tables(annotation))


def tag_key(table: type[BaseModel]) -> str:
    """The key by which a table is chosen among others."""
    return "model" if "model" in table.model_fields else "kind"


def tags(table: type[BaseModel]) -> tuple[Any, ...]:
    """The values of that key; none of a table that is not chosen."""
    field = table.model_fields.get(tag_key(table))
    return typing.get_args(field.annotation) if field is not None else ()
