"""The reference of all scene keys as Markdown, made from the validators: `python -m benchmarks.scene_keys`.

A table has one section, however many places of a scene may hold it. Its heading is the shortest of these places, with
the model where a place offers several. Headings differ from one another, so that every link finds its section.
"""

from __future__ import annotations

import re
import types
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from pipelines.io.toml_text import format_value
from pipelines.scene.scene import Scene
from pipelines.scene.tables.scene_table import is_list, tables, tag_key, tags
from pipelines.scene.tables.series import ColumnTable
from pipelines.scene.validation_messages import unit_of

HEAD = """# Scene keys

This page lists every key of a scene file. It is made from the program by
`python -m benchmarks.scene_keys docs/scene-keys.md`.

- The suffix of a key is its unit: `face_width_mm`, `speeds_rpm`, `torque_N_m`. Without a suffix a number has no unit.
- "Without it" means: if the scene does not give the key. "Empty" means: the list `[]`.
- x points across the shafts, y along them and z up. Shaft 1 is at x = z = 0, and y = 0 is the middle of the housing.
- `[name]` is a table, `[[name]]` an item of a list of tables. Messages and `--set stages.1.face_width_mm=14` count
  items from 1.
- The key `model` chooses the table of a model, `kind` that of a fault.
- `extends = "rig-healthy"` at the top of a file inherits every value of that scene that the file does not give. Tables
  are merged key by key, so inherited windows stay. Lists are replaced; a table `[stages.1]` changes one item of an
  inherited list. Below `[[shafts]]` of the same file the number is omitted, as in `[[shafts.bearings]]`.
"""
TOP = "Top level"
FROM_FILE = "values from a file"
Tables = tuple[type[BaseModel], ...]


@dataclass
class _Sections:
    """Where the tables of a scene may be: places by tables, in the order in which a scene offers them."""

    places: dict[Tables, list[str]] = field(default_factory=dict)
    parents: dict[Tables, list[type[BaseModel]]] = field(default_factory=dict)

    def collect(self, table: type[BaseModel], path: str) -> None:
        """Note the tables below one that is at the path, e.g. "stages[].mesh" for the key `mesh` of a stage."""
        for name, member in table.model_fields.items():
            inner = tables(member.annotation)
            if not inner:
                continue
            place = ".".join(part for part in (path, f"{name}[]" if is_list(member.annotation) else name) if part)
            if table not in (above := self.parents.setdefault(inner, [])):
                above.append(table)
            if place not in (known := self.places.setdefault(inner, [])):
                known.append(place)
                for one in inner:
                    self.collect(one, place)

    def heading(self, members: Tables) -> str:
        """Heading of the section of one table, or of a choice of tables."""
        if members == (ColumnTable,):
            return FROM_FILE
        found = _shortest(self.places[members])
        same = [other for other, places in self.places.items() if _shortest(places) == found]
        return f"{found}: {', '.join(map(_value, self.parents[members]))}" if len(same) > 1 else found

    def link(self, members: Tables) -> str:
        """Link to that section."""
        return f"[{self.heading(members)}](#{slug(self.heading(members))})"

    def ordered(self) -> list[Tables]:
        """All sections: those below a key of the scene together, in the order of these keys."""
        top = [*Scene.model_fields, FROM_FILE]
        return sorted(self.places, key=lambda members: top.index(re.split("[.:]", self.heading(members))[0]))


def slug(heading: str) -> str:
    """Anchor of a heading, as MyST and hosts of Markdown make it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def scene_keys() -> str:
    """The whole page."""
    sections = _Sections()
    sections.collect(Scene, "")
    lines = [f"\n## {TOP}", *_rows(Scene, sections)]
    for members in sections.ordered():
        lines += _section(members, sections)
    return HEAD + "\n".join(lines) + "\n"


def _section(members: Tables, sections: _Sections) -> Iterator[str]:
    """The lines of a table, or of a choice of tables with the sections of each."""
    heading = sections.heading(members)
    level = "###" if "." in heading else "##"
    yield f"\n{level} {heading}"
    places = ", ".join(f"`{_header(place)}`" for place in sections.places[members])
    if len(members) == 1:
        yield f"\n{_text(members[0])}\n\n{places}"
        yield from _rows(members[0], sections)
        return
    tag = tag_key(members[0])
    links = ", ".join(f"[{_value(one)}](#{slug(f'{heading}: {_value(one)}')})" for one in members)
    yield f"\n{places}: one of the tables {links}, chosen by `{tag}`."
    for number, one in enumerate(members):
        yield f"\n### {heading}: {_value(one)}\n\n`{tag} = {format_value(_value(one))}`: {_text(one)}"
        other = max((m for m in members[:number] if _keys(m).items() <= _keys(one).items()), key=_count, default=None)
        if other is not None and _keys(other):
            yield f"\nAll keys of [{_value(other)}](#{slug(f'{heading}: {_value(other)}')}), and:"
        yield from _rows(one, sections, _keys(other) if other is not None else {})


def _rows(
    table: type[BaseModel], sections: _Sections, known: Mapping[str, str] = MappingProxyType({})
) -> Iterator[str]:
    """Rows of the keys of a table, without those that are known from another one."""
    members = {
        name: member for name, member in table.model_fields.items() if name in _keys(table).keys() - known.keys()
    }
    yield "\n| key | meaning | values | default |\n|---|---|---|---|" if members else "\nNo other keys."
    for name, member in members.items():
        inner = tables(member.annotation)
        meaning, held = (member.description or "").replace("|", "\\|"), values(member, name)
        if inner == (ColumnTable,):
            held = held.removesuffix("table") + sections.link(inner)
        elif inner:
            meaning += (": " if meaning else "") + sections.link(inner)
        yield f"| `{name}` | {meaning} | {held} | {default(member)} |"


def values(member: FieldInfo, name: str) -> str:
    """What a key may hold: kind of value, limits and unit."""
    return _kind(member.annotation, member.metadata, unit_of(name))


def _kind(annotation: Any, limits: list[Any], unit: str) -> str:
    origin, arguments = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Annotated:
        inner = [one for item in arguments[1:] for one in (item.metadata if isinstance(item, FieldInfo) else [item])]
        return _kind(arguments[0], [*inner, *limits], unit)
    if origin is typing.Literal:
        *first, last = (f"`{format_value(choice)}`" for choice in arguments)
        return f"{', '.join(first)} or {last}" if first else last
    if origin in (typing.Union, types.UnionType):
        kinds = [_kind(one, limits, unit) for one in arguments if one is not type(None)]
        return ", or ".join(dict.fromkeys(kinds))
    if origin is tuple and arguments[-1] is ...:
        item = _several(_kind(arguments[0], [], unit))
        return item if item.startswith("rows") else f"list of {item}"
    if origin is tuple:
        kinds = [_kind(one, [], unit) for one in arguments]
        if len(set(kinds)) == 1:
            return f"{len(kinds)} {_several(kinds[0])}"
        return f"{len(kinds)} numbers ({'; '.join(kinds)})"
    if origin is dict:
        return f"table of names, each {_kind(arguments[1], [], unit)}"
    if annotation is bool:
        return "`true` or `false`"
    if annotation is str:
        return "text"
    if annotation is int:
        return ", ".join(["whole number", *_range(limits)])
    if annotation is float:
        limit = " and ".join(_range(limits))
        return f"{limit} {unit}".rstrip() if limit else f"number in {unit}" if unit else "number"
    return "table"


def _several(kind: str) -> str:
    """Many of a kind of value: numbers, rows of numbers, tables."""
    if kind[0].isdigit() and " numbers" in kind:
        return f"rows of {kind}"
    plural = re.sub(r"^(whole number|number|table|text)", r"\1s", kind)
    return kind if kind.startswith("`") else plural if plural != kind else f"numbers, {kind}"


def _range(limits: list[Any]) -> list[str]:
    """The narrowest bounds of a number as text; nothing where it has none."""
    low = [(float(typing.cast(Any, one.ge)), "at least") for one in limits if isinstance(one, Ge)]
    low += [(float(typing.cast(Any, one.gt)), "above") for one in limits if isinstance(one, Gt)]
    high = [(float(typing.cast(Any, one.le)), "at most") for one in limits if isinstance(one, Le)]
    high += [(float(typing.cast(Any, one.lt)), "below") for one in limits if isinstance(one, Lt)]
    least, most = max(low, default=None), min(high, default=None)
    if least and most and (least[1], most[1]) == ("at least", "at most"):
        return [f"{_number(least[0])} to {_number(most[0])}"]
    return [f"{words} {_number(bound)}" for bound, words in filter(None, (least, most))]


def _number(value: float) -> str:
    short = f"{value:g}".replace("e+0", "e")
    return short if float(short) == value and abs(value) >= 1e6 else f"{value:.0f}" if value.is_integer() else short


def default(member: FieldInfo) -> str:
    """The default as it is written in a scene."""
    if member.is_required():
        return "required"
    value: Any = member.default if member.default_factory is None else member.default_factory()  # type: ignore[call-arg]
    if isinstance(value, BaseModel):
        return (
            f"{tag_key(type(value))} `{_value(type(value))}`" if len(tables(member.annotation)) > 1 else "its defaults"
        )
    return "none" if value is None else f"`{format_value(value)}`"


def _text(table: type[BaseModel]) -> str:
    return " ".join((table.__doc__ or "").split())


def _keys(table: type[BaseModel]) -> dict[str, str]:
    """Keys of a table with all that is written of them, without the key by which it is chosen."""
    return {name: repr(member) for name, member in table.model_fields.items() if not _chooses(member)}


def _count(table: type[BaseModel]) -> int:
    return len(_keys(table))


def _chooses(member: FieldInfo) -> bool:
    """Whether a key has one value only: the one by which its table is chosen, which the heading gives."""
    return typing.get_origin(member.annotation) is typing.Literal and len(typing.get_args(member.annotation)) == 1


def _value(table: type[BaseModel]) -> str:
    """The value by which a table is chosen among others."""
    return str(tags(table)[0])


def _shortest(places: list[str]) -> str:
    return _plain(min(places, key=lambda place: place.count(".")))


def _plain(place: str) -> str:
    return place.replace("[]", "")


def _header(place: str) -> str:
    """A place as the header of its table in TOML."""
    return f"[[{_plain(place)}]]" if place.endswith("[]") else f"[{_plain(place)}]"


if __name__ == "__main__":
    import sys

    Path(sys.argv[1]).write_text(scene_keys(), encoding="utf-8")
