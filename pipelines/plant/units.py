"""From the units of a scene to SI, by the ends of the keys ("depth_mm" = 2 is depth = 0.002 m)."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from pipelines.scene.tables.base import Table

UNITS: dict[str, Callable[[float], float]] = {  # divisions by exact integers: 4 um is the double nearest to 4e-6
    "mm": lambda value: value / 1000,
    "um": lambda value: value / 1_000_000,
    "deg": math.radians,
    "Hz": lambda value: value,
}


def si_options(table: Table, *, without: type[Table]) -> dict[str, Any]:
    """The values of a table in SI by their names without units; not its kind, and not the keys of the base class."""
    options: dict[str, Any] = {}
    for key in type(table).model_fields:
        if key in without.model_fields or key == "kind":
            continue
        value = getattr(table, key)
        name, _, unit = key.rpartition("_")
        if unit in UNITS:
            options[name] = _converted(UNITS[unit], value)
        else:
            options[key] = value
    return options


def _converted(convert: Callable[[float], float], value: Any) -> Any:
    """A number or each of several; None stays."""
    if isinstance(value, tuple):
        return tuple(map(partial(_converted, convert), value))
    return None if value is None else convert(value)
