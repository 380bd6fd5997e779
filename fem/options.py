"""Options: fields of frozen dataclasses that a scene gives, with unit, range and text. Each is defined once, here.

A field holds the value in SI; a scene gives it in the unit of the option, which is the end of its key: `depth` with the
unit mm is "depth_mm". Limits are in that unit. Keys, conversion, validation, schema and documentation of a scene are
derived by `pipelines.scene.tables.derived`. This module imports nothing but the standard library.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import typing
from dataclasses import MISSING, dataclass
from typing import Any

# divisors are exact integers, so that 4 um is the double nearest to 4e-6
_OVER = {"mm": 1000, "um": 1_000_000, "us": 1_000_000, "mrad": 1000, "mPa s": 1000, "g mm": 1_000_000}
_TIMES = {"N/um": 1e6, "GPa": 1e9, "deg": math.radians(1.0), "rpm": math.tau / 60}


UNITS = (*_OVER, *_TIMES)  # those that are not SI already


def key_suffix(unit: str) -> str:
    """The end of a key for a unit: N_per_um of N/um."""
    return unit.replace("/", "_per_").replace(" ", "_")


def in_si(value: Any, unit: str) -> Any:
    """A number or array in a unit, in SI; each of a tuple, at any depth; None stays."""
    if isinstance(value, tuple):
        return tuple(in_si(item, unit) for item in value)
    if value is None:
        return None
    if unit == "deg":
        return math.radians(value)
    return value / _OVER[unit] if unit in _OVER else value * _TIMES.get(unit, 1)


@dataclass(frozen=True, kw_only=True)
class Option:
    """What a scene may give for a field: `text` describes it, `key` replaces the name of the field in it."""

    text: str
    unit: str = ""
    key: str = ""
    ge: float | None = None
    gt: float | None = None
    le: float | None = None
    lt: float | None = None
    least: int | None = None  # items of a tuple
    most: int | None = None
    pattern: str | None = None  # of a text, a regular expression

    def si(self, value: float) -> float:
        """A value in the unit of the option, in SI."""
        return in_si(value, self.unit)

    def given(self, value: float) -> float:
        """A value in SI in the unit of the option, as a user would write it."""
        return float(f"{value / self.si(1.0):.12g}") if self.unit else value

    @property
    def range(self) -> str:
        """The limits in words, in the unit of the option."""
        bounds = {"at least": self.ge, "above": self.gt, "at most": self.le, "below": self.lt}
        words = " and ".join(f"{name} {bound:g}" for name, bound in bounds.items() if bound is not None)
        if self.ge is not None and self.le is not None:
            words = f"{self.ge:g} to {self.le:g}"
        return f"{words or 'a finite number'} {self.unit}".rstrip()

    def holds(self, value: float) -> bool:
        """Whether a value in SI is inside the limits."""
        return (
            math.isfinite(value)
            and (self.ge is None or value >= self.si(self.ge))
            and (self.gt is None or value > self.si(self.gt))
            and (self.le is None or value <= self.si(self.le))
            and (self.lt is None or value < self.si(self.lt))
        )


def option(default: Any = MISSING, *, text: str, unit: str = "", key: str = "", **limits: Any) -> Any:
    """A field of a dataclass that a scene may give.

    Parameters
    ----------
    default : in SI; without it the scene must give a value
    text, unit, key, **limits : those of `Option`
    """
    given = Option(text=text, unit=unit, key=key, **limits)
    return dataclasses.field(default=default, metadata={"option": given})


def inline(default: Any = MISSING) -> Any:
    """A field of a dataclass whose options a scene gives in the table of its owner."""
    return dataclasses.field(default=default, metadata={"inline": True})


@functools.cache
def inlined(owner: type) -> tuple[tuple[str, type], ...]:
    """Names and classes of the fields of a dataclass that are `inline`."""
    hints = typing.get_type_hints(owner)
    return tuple((f.name, hints[f.name]) for f in dataclasses.fields(owner) if "inline" in f.metadata)


@functools.cache
def options_of(owner: type) -> tuple[tuple[dataclasses.Field, Option], ...]:
    """The fields of a dataclass that are options."""
    return tuple((f, f.metadata["option"]) for f in dataclasses.fields(owner) if "option" in f.metadata)


def check_options(owner: Any, error: type[Exception], name: str = "") -> None:
    """Raise an error that names the first option outside its limits or choices; None is inside.

    Parameters
    ----------
    owner, error : the object, and what is raised
    name : of the object in the message; without it: its class
    """
    where = name or type(owner).__name__
    for field, one in options_of(owner.__class__):
        value, choices = getattr(owner, field.name), _choices(owner.__class__).get(field.name, ())
        if choices and value not in choices:
            words = ", ".join(map(repr, choices))
            raise error(f"{where}: {field.name} = {value!r}: must be one of {words}")
        for number in value if isinstance(value, tuple) else (value,):
            if isinstance(number, int | float) and not one.holds(number):
                given = f"{one.given(number):g} {one.unit}".rstrip()
                raise error(f"{where}: {field.name} = {given}: must be {one.range}")


@functools.cache
def _choices(owner: type) -> dict[str, tuple[Any, ...]]:
    """The values of the fields that have a `Literal` type."""
    hints = typing.get_type_hints(owner).items()
    return {name: typing.get_args(hint) for name, hint in hints if typing.get_origin(hint) is typing.Literal}
