"""Tables of a scene, derived from the dataclasses that define their options (`fem.options`), and back to these."""

from __future__ import annotations

import dataclasses
import functools
import operator
import types
import typing
from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import Field, create_model

from fem.options import Option, options_of
from pipelines.scene.tables.base import Flag, Number, Table, Whole

_STRICT = {float: Number, int: Whole, bool: Flag}
_SUFFIXES = {"N/um": "N_per_um", "N m/rad": "N_m_per_rad"}  # where it is not the unit with underscores


class DerivedTable(Table):
    """A table whose keys are the options of a class."""

    def made(self, **others: Any) -> Any:
        """An object of the class in SI, with fields that are no options of a scene."""
        made = _MADE[type(self)]
        values = {field.name: _converted(getattr(self, _key(field.name, one)), one) for field, one in options_of(made)}
        return made(**values, **others)


_MADE: dict[type[DerivedTable], type] = {}


@functools.cache
def table(made: type, name: str = "") -> Any:
    """The table class of a dataclass: its options as keys, and its field `model` or `kind`, if it has one, as tag."""
    hints = typing.get_type_hints(made)
    keys: dict[str, Any] = {}
    for field in dataclasses.fields(made):
        if field.name in ("model", "kind") and typing.get_origin(hints[field.name]) is typing.Literal:
            keys[field.name] = (hints[field.name], field.default)
    for field, one in options_of(made):
        limits = {bound: getattr(one, bound) for bound in ("ge", "gt", "le", "lt") if getattr(one, bound) is not None}
        annotation: Any = Annotated[_strict(hints[field.name]), Field(description=one.text, **limits)]
        default = ... if field.default is dataclasses.MISSING else _given(field.default, one)
        keys[_key(field.name, one)] = (annotation, default)
    doc = (made.__doc__ or "").split("\n\n")[0]
    found = create_model(name or made.__name__, __base__=DerivedTable, __doc__=doc, **keys)
    _MADE[found] = made
    return found


def choice(classes: Iterable[type]) -> Any:
    """The tables of several dataclasses, of which the field `model` or `kind` chooses one."""
    tables = [table(one) for one in classes]
    tag = "model" if "model" in tables[0].model_fields else "kind"
    return Annotated[functools.reduce(operator.or_, tables), Field(discriminator=tag)]


def _key(name: str, one: Option) -> str:
    suffix = _SUFFIXES.get(one.unit, one.unit.replace(" ", "_"))
    return one.key or (f"{name}_{suffix}" if suffix else name)


def _strict(annotation: Any) -> Any:
    """A type whose numbers are taken as written: text is no number, true is not 1."""
    if annotation in _STRICT:
        return _STRICT[annotation]
    inner: tuple[Any, ...] = tuple(one if one is ... else _strict(one) for one in typing.get_args(annotation))
    origin = typing.get_origin(annotation)
    if not inner or origin is typing.Literal:
        return annotation
    if origin in (typing.Union, types.UnionType):
        return functools.reduce(operator.or_, inner)
    return origin[inner]


def _converted(value: Any, one: Option) -> Any:
    """A value of a table in SI."""
    if isinstance(value, tuple):
        return tuple(_converted(item, one) for item in value)
    if isinstance(value, DerivedTable):
        return value.made()
    return one.si(value) if one.unit and value is not None else value


def _given(value: Any, one: Option) -> Any:
    """A default in SI in the unit of a table, the number that a user would write."""
    if isinstance(value, tuple):
        return tuple(_given(item, one) for item in value)
    if not one.unit or not isinstance(value, int | float):
        return value
    return float(f"{value / one.si(1.0):.12g}")
