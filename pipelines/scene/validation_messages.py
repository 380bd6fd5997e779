"""Messages for errors of validation, with path, value, limit, remedy and nearest key.

This works for any pydantic model: limits come from its constraints, units from the suffixes of keys, explanations from
the descriptions of fields.
"""

from __future__ import annotations

import functools
import math
import typing
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from pipelines.io.errors import Problem, problem_of
from pipelines.io.shown_text import MOST_CHARACTERS, nearest_name, shown_value
from pipelines.scene.merge import no_item
from pipelines.scene.tables.scene_table import is_list, tables, tags

UNITS = {  # by the suffix of a key, longer suffixes first
    "N_m_s_per_rad": "N m s/rad", "N_m_per_rad": "N m/rad", "N_per_um": "N/um", "kg_m2": "kg m2", "kg_m3": "kg/m3",
    "m_s2": "m/s2", "N_m": "N m", "g_mm": "g mm", "mPa_s": "mPa s", "mm": "mm", "um": "um", "us": "us", "deg": "deg",
    "mrad": "mrad", "rpm": "rpm", "GPa": "GPa", "kg": "kg", "Hz": "Hz", "m": "m", "s": "s", "N": "N",
}  # fmt: skip
_OTHER_UNITS = ("mpa", "ms", "khz", "kn", "nm", "percent")  # suffixes that users may append to keys

RENAMED = {"casing.coupling": "attachment", "full_scale": "scale"}  # keys of earlier versions
_TORQUE = "The load gives the torque of a stage: set it in [load], or use --torque of gearcase gears."
_ELSEWHERE = {  # keys that are often written in a table that does not have them, by table and key
    ("", "preset"): "Use the option --preset.",
    ("", "extends"): 'Write extends = "..." in the scene file.',
    ("stages", "torque_N_m"): _TORQUE,
    ("stages", "torques_N_m"): _TORQUE,
}
_MOST_WORDED = 50  # errors of one validation with a message; a file of another program has thousands
_MOST_ITEMS = 30  # items of a list that are searched for keys
_ONE_QUANTITY = 0.62  # share of common letters, without units, of two keys of one quantity; width and depth have 0.6
_OF_OTHER_TABLE = 0.8  # share of common letters of a key and one of another table
_Paths = Callable[[], list[tuple[str, ...]]]


def unit_of(key: str) -> str:
    """The unit of a key by its suffix; "" if it has none."""
    return next((unit for suffix, unit in UNITS.items() if key.endswith(f"_{suffix}")), "")


def problems_of(error: ValidationError, model: type[BaseModel], tree: Mapping[str, Any]) -> tuple[list[Problem], int]:
    """The problems of one validation as messages, without repeats, and the number of further errors."""
    out: dict[Problem, None] = {}
    items: list[Any] = [  # a list may be too short only because of invalid items, which have separate errors
        item
        for item in error.errors(include_url=False)
        if not (item["type"] == "too_short" and len(item["input"]) >= item["ctx"]["min_length"])
    ]
    paths = functools.cache(lambda: _all_paths(_Place(model, tree)))
    for item in items[:_MOST_WORDED]:
        own = getattr(item.get("ctx", {}).get("error"), "problems", None)
        out.update(dict.fromkeys(own or _own_words(item, model, tree, paths)))
    return _joined(_without_duplicates(out)), max(0, len(items) - _MOST_WORDED)


def _without_duplicates(found: Iterable[Problem]) -> list[Problem]:
    """The problems except for missing keys that are written under a misspelt name, which is a problem already."""
    out = list(found)
    meant = {
        f"{one.path.rpartition('.')[0]}.{one.remedy.removeprefix('Did you mean ').rstrip('?')}".lstrip(".")
        for one in out
        if " is not a key of " in f" {one.message}" and one.remedy.startswith("Did you mean ")
    }
    return [one for one in out if not (one.message == "is missing" and one.path in meant)]


def _joined(found: Iterable[Problem]) -> list[Problem]:
    """The problems, with a single one for a value that is neither the number nor the list that its key accepts."""
    out: list[Problem] = []
    for one in found:
        before = out[-1] if out else None
        same = before is not None and (before.path, before.shown) == (one.path, one.shown)
        if before is not None and same and before.message.startswith("must be a number") and one.message == _LIST[0]:
            message = before.message.replace("must be a number", "must be a number or a list of numbers", 1)
            out[-1] = Problem(one.path, message, before.remedy, one.shown)
        elif before is not None and same and before.message.startswith("must be ") and one.message == _LIST[0]:
            continue  # the number is out of range, so the message on lists does not help
        else:
            out.append(one)
    return out


def _own_words(item: Any, model: type[BaseModel], tree: Mapping[str, Any], paths: _Paths) -> list[Problem]:
    """Problems of an error: the lines of a check of this program, or the message for an error of the library."""
    if item["type"] != "value_error":
        return [_problem(item, model, tree, paths)]
    where = ".".join(user_path(item["loc"], model, tree))
    return [problem_of(where, line) for line in str(item["ctx"]["error"]).splitlines()]


@dataclass(frozen=True)
class _Place:
    """A place in the tree of a scene: allowed contents, actual contents, and its field in the table around it."""

    annotation: Any
    value: Any
    field: FieldInfo | None = None
    in_list: bool = False

    @property
    def is_table(self) -> bool:
        """True if a table may be here, not a list of tables or a value."""
        return bool(tables(self.annotation)) and (self.in_list or not is_list(self.annotation))

    @property
    def tables(self) -> list[type[BaseModel]]:
        """The tables that may be here: those of the model that the value selects, or all."""
        members = [*tables(self.annotation)] if self.is_table else []
        tag = self.value.get("model", self.value.get("kind")) if isinstance(self.value, Mapping) else None
        return [one for one in members if tag in tags(one)] or members

    @property
    def keys(self) -> list[str]:
        """The keys of the tables that may be here."""
        return list(dict.fromkeys(name for one in self.tables for name in one.model_fields))

    def below(self, step: str) -> _Place:
        """The place of a key of the table here, or of an item (from 1) of the list here."""
        if isinstance(self.value, list | tuple) and step.isdecimal():
            held = self.value[int(step) - 1] if 0 < int(step) <= len(self.value) else None
            return _Place(self.annotation, held, in_list=True)
        held = self.value.get(step) if isinstance(self.value, Mapping) else None
        field = next((one.model_fields[step] for one in self.tables if step in one.model_fields), None)
        named = typing.get_args(self.annotation)[1] if typing.get_origin(self.annotation) is dict else None
        return _Place(named if field is None else field.annotation, held, field)


def _at(path: Iterable[str], model: Any, tree: Any) -> _Place:
    return functools.reduce(_Place.below, path, _Place(model, tree))


def user_path(location: Iterable[int | str], model: Any, tree: Any, *, missing: bool = False) -> tuple[str, ...]:
    """The path of an error as a user writes it: items count from 1, and tags of models are omitted.

    Parameters
    ----------
    location : keys and numbers of items, from 0
    model, tree : class and tree of the validation
    missing : True if the last key is not in the tree
    """
    path: tuple[str, ...] = ()
    place, steps = _Place(model, tree), list(location)
    for number, step in enumerate(steps):
        ends = missing and number == len(steps) - 1
        members = tables(place.annotation)
        chosen = [one for one in members if step in (*tags(one), one.__name__)] if len(members) > 1 else []
        is_item = isinstance(step, int) and isinstance(place.value, list | tuple)
        if chosen and not ends:
            place = _Place(chosen[0], place.value)
        elif is_item or (isinstance(place.value, Mapping) and (step in place.value or ends)):
            path += (str(step + 1 if isinstance(step, int) else step),)
            place = place.below(path[-1])
    return path


def _problem(item: Any, model: type[BaseModel], tree: Mapping[str, Any], paths: _Paths) -> Problem:
    kind, context, location = item["type"], item.get("ctx", {}), item["loc"]
    path = user_path(location, model, tree, missing=kind == "missing")
    key, where = (path[-1] if path else ""), ".".join(path)
    unit = _unit(key)
    value = item["input"]
    written = None if kind == "missing" else _shown(value)
    if kind == "extra_forbidden":
        return Problem(where, *_unknown_key(path, model, tree, paths), written)
    if kind == "missing" and isinstance(location[-1], int):  # a list of fixed length is too short
        return Problem(
            where.rpartition(".")[0],
            "has too few values",
            f"Give all of them{_meaning(path[:-1], model, tree)}.",
            _shown(value),
        )
    if kind == "missing":
        return Problem(where, "is missing", f"Set {_example(path, model, tree)}.")
    if kind in _LIMITS:
        words, name = _LIMITS[kind]
        limit = shown_number(context[name])
        return Problem(
            where,
            f"must be {words} {limit}{unit.removeprefix(' in')}",
            other_unit(key, value) or "Correct the value.",
            written,
        )
    if kind in ("literal_error", "union_tag_invalid", "enum"):
        if kind == "union_tag_invalid":
            where, value, written = f"{where}.{_tag_key(context)}", context["tag"], _shown(context["tag"])
            known = [w.strip(" '\"") for w in str(context["expected_tags"]).split(",")]
        else:
            known = [w.strip(" '\"") for w in str(context["expected"]).replace(" or ", ", ").split(",")]
        near = nearest_name(value, known) if isinstance(value, str) else ""
        remedy = f'Did you mean "{near}"?' if near else "Correct the value."
        return Problem(where, f"must be one of {', '.join(known)}", remedy, written)
    if kind == "union_tag_not_found":
        key = _tag_key(context)
        known = [str(tag) for member in _at(path, model, tree).tables for tag in tags(member)]
        return Problem(f"{where}.{key}", "is missing", f"Set {key} to one of {', '.join(known)}.")
    if kind.startswith(("float", "int", "decimal")) or kind == "finite_number":
        noun = "a whole number" if kind.startswith("int") else "a finite number" if "finite" in kind else "a number"
        return Problem(
            where,
            f"must be {noun}{unit}",
            "Write the number alone, without quotes and unit." if isinstance(value, str) else "Correct the value.",
            written,
        )
    if kind == "string_pattern_mismatch":
        return Problem(where, "does not have the required form", f"Correct it{_meaning(path, model, tree)}.", written)
    if kind in _KINDS:
        message, remedy = _KINDS[kind]
        if message == _LIST[0] and isinstance(value, Mapping) and value and all(name.isdecimal() for name in value):
            return Problem(f"{where}.{next(iter(value))}", *no_item(where, next(iter(value)), 0))
        if message == _LIST[0] and isinstance(value, Mapping):
            remedy = (
                f"Write [[{where}]] before each of its tables; to change item 1: [{where}.1] or --set {where}.1.key."
            )
        elif message == _LIST[0] and path[-1].isdigit():
            remedy = "Write each row in square brackets, as in [[value, value], [value, value]]."
        if message == _TABLE[0] and unit:  # the key is a quantity over time
            message, remedy = (
                f"must be a list of numbers{unit}",
                "Write [value, value, ...], or { file = ..., column = ... }.",
            )
        if kind == "string_type" and (meaning := _meaning(path, model, tree)):
            remedy += f". Meaning{meaning}"
        return Problem(where, message, remedy, written)
    if kind in ("too_short", "too_long"):
        bound = "at least" if kind == "too_short" else "at most"
        limit = context.get("min_length", context.get("max_length"))
        return Problem(
            where, f"has {context['actual_length']} items, and must have {bound} {limit}", "Correct the list.", None
        )
    return Problem(where, str(item["msg"]), "", None if isinstance(value, Mapping | list | BaseModel) else written)


_LIMITS = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
    "multiple_of": ("a multiple of", "multiple_of"),
}
_USUAL = {  # by key, or by the unit of a key: other units, factors, and usual values
    "amount_um": ((("mm", 1e3),), 0.05, math.inf),
    "length_mm": ((("m", 1e3),), 0.01, math.inf),
    "depth_mm": ((("m", 1e3),), 5e-3, math.inf),
    "in_plane_um": ((("mm", 1e3),), 0.05, math.inf),
    "out_of_plane_um": ((("mm", 1e3),), 0.05, math.inf),
    "helix_angle_deg": ((("rad", 180 / math.pi),), 0.5, math.inf),
    "GPa": ((("MPa", 1e-3), ("Pa", 1e-9)), 1.0, 2000.0),
    "mm": ((("m", 1e3),), 0.05, 10e3),
    "kg/m3": ((("g/cm3", 1e3), ("t/mm3", 1e12)), 500.0, 25e3),
}
_TABLE = ("must be a table", "Write it as { key = value }, or write its keys below a line with its name in brackets.")
_LIST = ("must be a list", "Write its values in square brackets, separated by commas.")
_KINDS = {
    "string_type": ("must be text", "Put it in quotes, in a shell as in --set 'KEY=\"VALUE\"'"),
    "bool_type": ("must be true or false", "Write true or false, without quotes."),
    "bool_parsing": ("must be true or false", "Write true or false, without quotes."),
    "dict_type": _TABLE,
    "model_type": _TABLE,
    "model_attributes_type": _TABLE,
    "list_type": _LIST,
    "tuple_type": _LIST,
    "string_too_long": ("is too long", "Shorten it."),
    "string_too_short": ("must not be empty", "Give some text."),
}


def other_unit(key: str, value: Any) -> str:
    """Remedy with the unit in which an unusual value of a key would be usual; "" if there is none."""
    unit = unit_of(key)
    others, low, high = _USUAL.get(key) or _USUAL.get(unit, ((), 0.0, 0.0))
    for other, factor in others:
        if isinstance(value, int | float) and not low <= value <= high and low <= value * factor <= high:
            return f"Convert it if it is in {other}: {value:g} {other} = {value * factor:g} {unit}."
    return ""


def _tag_key(context: Mapping[str, Any]) -> str:
    """The key that selects the model of a table: model, or kind for faults."""
    key = str(context["discriminator"]).strip("'")
    return key if key.isidentifier() else "model"  # a function selects the table if the model has a default


def _unknown_key(
    path: tuple[str, ...], model: type[BaseModel], tree: Mapping[str, Any], paths: _Paths
) -> tuple[str, str]:
    table = ".".join(path[:-1])
    known = _at(path[:-1], model, tree).keys
    whole = model.__name__.removesuffix("Table").lower()
    message = f"is not a key of [{table}]" if table else f"is not a key of the {whole}"
    if path[-1].isdecimal():  # [[shafts.2.bearings]] below [[shafts]]
        name = ".".join(part for part in path if not part.isdecimal())
        return message, f"Below [[{name}]] write its tables without the number: [{name}.NAME] or [[{name}.NAME]]."
    if other_models := _models_with(path, model, tree):
        return message, f"It belongs to {' or '.join(other_models)}: set that, or delete the key."
    near = RENAMED.get(".".join(path)) or nearest(path[-1], known)
    if near and ("", path[-1]) not in _ELSEWHERE:
        return message, f"Did you mean {near}?"
    head = path[0] if len(path) > 1 else ""
    if other := nearest(path[-1], [key for start, key in _ELSEWHERE if start == head]):
        return message, _ELSEWHERE[head, other]
    tail = nearest(path[-1], [key.partition("_")[2] for key in known if "_" in key]) or path[-1]
    if longer := [key for key in known if key.endswith(f"_{tail}")]:  # bor_mm: pinion_bore_mm, wheel_bore_mm
        return message, f"Did you mean {' or '.join(longer)}?"
    if len(path) > 1:
        start = f"{path[-2]}_"
        parts = [k.removeprefix(start) for k in _at(path[:-2], model, tree).keys if k.startswith(start)]
        if part := nearest(path[-1], parts):  # pinion.teth: pinion_teeth
            return message, f"Did you mean {'.'.join((*path[:-2], start + part))}?"
    if other := nearest_name(path[-1], dict.fromkeys(p[-1] for p in paths()), _OF_OTHER_TABLE):
        same_head_first = min((p for p in paths() if p[-1] == other), key=lambda p: p[0] != path[0])
        return message, f"Did you mean {'.'.join(same_head_first)}?"
    return message, f"Known keys: {', '.join(known)}." if known else ""


def _models_with(path: tuple[str, ...], model: type[BaseModel], tree: Mapping[str, Any]) -> list[str]:
    """The models of the table at a path that have its last key, as in ``model = "hertz"``."""
    place = _at(path[:-1], model, tree)
    tag = "kind" if isinstance(place.value, Mapping) and "kind" in place.value else "model"
    having = [one for one in tables(place.annotation) if path[-1] in one.model_fields] if place.is_table else []
    return [f'{tag} = "{name}"' for one in having for name in tags(one)]


def nearest(word: str, known: Iterable[str]) -> str:
    """The known word closest to `word`, ignoring case and order of parts; "" if only the unit is similar.

    The only one with the same parts but the unit, or with these and further parts, overrides more similar ones.
    """
    names = list(known)
    folded = {name.lower(): name for name in names}
    word = word[:MOST_CHARACTERS]
    head = _quantity(word.lower())
    parts = set(head.split("_"))
    others = {name: set(_quantity(lower).split("_")) for lower, name in folded.items() if lower != head}
    same = [name for name, other in others.items() if other == parts]
    more = [name for name, other in others.items() if len(parts) > 1 and other > parts]
    for found in (same, more):
        if len(found) == 1:
            return found[0]
    for cutoff, table in ((0.6, folded), (0.8, {"_".join(sorted(n.split("_"))): folded[n] for n in folded})):
        asked = word.lower() if table is folded else "_".join(sorted(word.lower().split("_")))
        match = nearest_name(asked, table, cutoff)
        if match and nearest_name(_quantity(asked), [_quantity(match)], _ONE_QUANTITY):
            return table[match]
    return ""


def _quantity(key: str) -> str:
    """A key without its unit."""
    head, _, unit = key.rpartition("_")
    return head if head and unit in (*map(str.lower, UNITS), *_OTHER_UNITS) else key


def _all_paths(place: _Place, path: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """Paths of all keys that a scene of this structure may have, from the top."""
    out: list[tuple[str, ...]] = []
    for name in place.keys:
        here, below = (*path, name), place.below(name)
        items = [str(number + 1) for number in range(len(below.value))] if isinstance(below.value, list | tuple) else []
        out += [here, *_all_paths(below, here)]
        for number in items[:_MOST_ITEMS]:
            out += _all_paths(below.below(number), (*here, number))
    return sorted(out, key=len)


def _example(path: tuple[str, ...], model: type[BaseModel], tree: Mapping[str, Any]) -> str:
    meaning = _meaning(path, model, tree)
    place, name = _at(path, model, tree), ".".join(path)
    if place.is_table:
        return f"the table [{name}]{meaning}"
    if tables(place.annotation) and not _unit(path[-1]):
        return f"a table [[{name}]] for each item{meaning}"
    return f"{path[-1]} = ...{meaning or _unit(path[-1])}"


def _meaning(path: tuple[str, ...], model: type[BaseModel], tree: Mapping[str, Any]) -> str:
    """Description of the key at a path after a colon; "" if it has none."""
    field = _at(path, model, tree).field
    return f": {field.description.rstrip('.')}" if field is not None and field.description else ""


def _unit(key: str) -> str:
    unit = unit_of(key)
    return f" in {unit}" if unit else ""


def shown_number(value: Any) -> str:
    """A value of a key, a real number to six digits."""
    return f"{value:g}" if isinstance(value, float) else str(value)


def _shown(value: Any) -> str | None:
    if value is None or isinstance(value, Mapping) or hasattr(value, "model_fields"):
        return None
    return shown_value(value, 60)
