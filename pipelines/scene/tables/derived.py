"""Tables of a scene, derived from the dataclasses that define their options (`fem.options`), and back to these."""

from __future__ import annotations

import dataclasses
import functools
import operator
import types
import typing
from collections.abc import Iterable, Iterator
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, create_model, model_validator

from fem.options import Option, inlined, key_suffix, options_of
from pipelines.scene.tables.scene_table import Flag, Number, Table, Whole
from pipelines.scene.tables.series import Samples, check_pairs, pairs

_STRICT = {float: Number, int: Whole, bool: Flag}


class DerivedTable(Table):
    """A table whose keys are the options of a class."""

    if typing.TYPE_CHECKING:

        def __getattr__(self, key: str) -> Any:
            """The value of an option."""

    use: ClassVar[str] = ""  # behind the name of the class, where that has tables for several uses
    made_of: ClassVar[type]
    alone: ClassVar[bool]  # whether the options are all that an object needs, and none of them is in a file
    series: ClassVar[tuple[str, ...]] = ()  # the keys of places and of values at these places, if there are any

    @model_validator(mode="after")
    def _makes_an_object(self) -> Self:
        """What an object refuses when it is made is a problem of the table."""
        if self.series:
            check_pairs(self, *self.series)
        if self.alone:
            self.made()
        return self

    def made(self, path: str = "", /, **others: Any) -> Any:
        """An object of the class in SI, with values for further fields; `path` of the table in messages on files."""
        return self.made_part(self.made_of, path, **others)

    def made_part(self, part: type, path: str = "", /, **others: Any) -> Any:
        """An object of a class whose options are among the keys; `others` are further fields, and win over options."""
        series = _series(part)
        read = dict(zip(series, pairs(self, series[0], series[1], path), strict=True)) if series else {}
        given = {}
        for field, one in options_of(part):
            key = key_of(field.name, one)
            given[field.name] = _si(read.get(key, getattr(self, key)), one, f"{path}.{key}")
        parts = {name: self.made_part(of, path) for name, of in inlined(part) if name not in others}
        return part(**given | parts | others)


class EitherTable(DerivedTable):
    """A table with the options of several classes; what it gives makes an object of one of them."""

    kinds: ClassVar[tuple[type, ...]]
    alone = True

    def made(self, path: str = "", /, **others: Any) -> Any:
        """An object of the class whose required options are given, in SI.

        Raises
        ------
        ValueError : they are those of none or of several
        """
        ways = {kind: [key for key, (_, default) in _keys(kind).items() if default is ...] for kind in self.kinds}
        given = {key for keys in ways.values() for key in keys if getattr(self, key) is not None}
        for kind, keys in ways.items():
            if given == set(keys):
                return self.made_part(kind, path, **others)
        choices = ", or ".join(" with ".join(keys) for keys in ways.values())
        raise ValueError(f"is located by {', '.join(sorted(given)) or 'no key'}. Set {choices}")


def _table(made_of: type, base: type[DerivedTable] = DerivedTable, **tag: tuple[str, str]) -> Any:
    """The table class of a dataclass: the keys of a base class, and its options.

    Parameters
    ----------
    made_of : the dataclass; its field `model`, if there is one, chooses the table
    base : of the table, with keys of the scene alone
    **tag : instead, the key that chooses the table, with its value and its text
    """
    hints = typing.get_type_hints(made_of, include_extras=True)
    keys: dict[str, Any] = {
        key: (Annotated[Literal[value], Field(description=text)], ...) for key, (value, text) in tag.items()
    }
    if typing.get_origin(hints.get("model")) is Literal:
        keys["model"] = (hints["model"], typing.get_args(hints["model"])[0])
    keys |= _keys(made_of)
    doc = (made_of.__doc__ or "").split("\n\n")[0]
    made = create_model(made_of.__name__ + base.use, __base__=base, __doc__=doc, **keys)
    made.made_of, made.series = made_of, _series(made_of)
    made.alone = not made.series and all(
        "option" in f.metadata or f.default is not dataclasses.MISSING for f in dataclasses.fields(made_of)
    )
    return made


table: Any = functools.cache(_table)  # a class has one table


def either(base: type[DerivedTable], *kinds: type) -> Any:
    """The table with the keys of a base class and the options of several classes, of which it gives one."""
    keys: dict[str, Any] = {key: given for kind in kinds for key, given in _keys(kind, optional=True).items()}
    made: Any = create_model(base.__name__.lstrip("_"), __base__=base, __doc__=base.__doc__, **keys)
    made.kinds = kinds
    return made


def _keys(made_of: type, *, optional: bool = False) -> dict[str, tuple[Any, Any]]:
    """The keys of a class, each with its type and default; if `optional`, those that must be given need not be."""
    keys = {}
    for field, hint, one in _options(made_of):
        given = Field(description=one.text, min_length=one.least, max_length=one.most, pattern=one.pattern)
        annotation, default = _strict(hint, one), _given(field.default, one)
        if default is dataclasses.MISSING:
            default = None if optional else ...
        if default is None:
            annotation = annotation | None
        keys[key_of(field.name, one)] = (Annotated[annotation, given], default)
    return keys


def _options(made_of: type) -> Iterator[tuple[dataclasses.Field, Any, Option]]:
    """The options of a class and of its inlined parts, with their types."""
    hints = typing.get_type_hints(made_of, include_extras=True)
    yield from ((field, hints[field.name], one) for field, one in options_of(made_of))
    for _, part in inlined(made_of):
        yield from _options(part)


@functools.cache
def _series(made_of: type) -> tuple[str, ...]:
    """The keys of options that are arrays."""
    return tuple(key_of(field.name, one) for field, hint, one in _options(made_of) if hint is np.ndarray)


def by_default(model: str) -> BeforeValidator:
    """Sets the model of a table that gives none."""
    return BeforeValidator(
        lambda value: {"model": model, **value} if isinstance(value, dict) and "model" not in value else value
    )


def choice(tables: Iterable[Any], key: str) -> Any:
    """Several tables, of which a key chooses one."""
    return Annotated[functools.reduce(operator.or_, tables), Field(discriminator=key)]


def key_of(name: str, one: Option) -> str:
    """The key of a scene for the field of that name."""
    suffix = key_suffix(one.unit)
    return one.key or (f"{name}_{suffix}" if suffix else name)


def _strict(annotation: Any, one: Option) -> Any:
    """A type whose numbers have limits and are taken as written: text is no number, true is not 1."""
    if annotation in (float, int):
        limits = {bound: getattr(one, bound) for bound in ("ge", "gt", "le", "lt") if getattr(one, bound) is not None}
        return Annotated[_STRICT[annotation], Field(**limits)] if limits else _STRICT[annotation]
    if annotation is bool:
        return Flag
    if annotation is np.ndarray:
        return Samples
    if isinstance(annotation, type) and dataclasses.is_dataclass(annotation):
        return table(annotation)
    if typing.get_origin(annotation) is Annotated:  # a number with separate limits
        return _strict(annotation.__origin__, *annotation.__metadata__)
    inner: tuple[Any, ...] = tuple(part if part is ... else _strict(part, one) for part in typing.get_args(annotation))
    origin = typing.get_origin(annotation)
    if not inner or origin is Literal:
        return annotation
    if origin in (typing.Union, types.UnionType):
        if all(isinstance(part, type) and issubclass(part, DerivedTable) for part in inner):
            return choice(inner, "model")
        return functools.reduce(operator.or_, inner)
    return origin[inner]


def _si(value: Any, one: Option, path: str) -> Any:
    """A value of a table at a path in SI."""
    if isinstance(value, tuple):
        return tuple(_si(item, one, path) for item in value)
    if isinstance(value, DerivedTable):
        return value.made(path)
    return one.si(value) if one.unit and value is not None else value


def _given(value: Any, one: Option) -> Any:
    """A default in SI in the unit of a table, the number that a user would write."""
    if isinstance(value, tuple):
        return tuple(_given(item, one) for item in value)
    return one.given(value) if one.unit and value not in (None, dataclasses.MISSING) else value
