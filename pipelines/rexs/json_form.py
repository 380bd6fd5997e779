"""REXS as JSON (.rexsj): the same components, relations and load cases under other brackets."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from pipelines.io.shown_text import shown, shown_value
from pipelines.rexs.document import Attribute, Document, Relation, RexsComponent, RexsError, by_number

_ABOUT = ("id", "unit")  # keys of an attribute, except the key of its value


def document_of_json(content: bytes, source: str) -> Document:
    """The document of a JSON text.

    Raises
    ------
    RexsError : no JSON, or see `document_of_model`
    """
    try:
        tree = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise RexsError(f"{source}: not valid JSON: {shown(str(error))}. Correct it.") from error
    return document_of_model(_table(_table(tree, source).get("model"), source), source)


def document_of_model(model: Mapping[str, Any], source: str) -> Document:
    """The document of the object "model" of REXS.

    Raises
    ------
    RexsError : not the structure of REXS
    """
    spectrum = _table(model.get("load_spectrum", {}), source)
    components = [_component(_table(one, source), source) for one in _list(model, "components", source)]
    return Document(
        source=source,
        version=str(model.get("version", "")),
        written_by=f"{model.get('applicationId', 'unknown')} {model.get('applicationVersion', '')}".strip(),
        components=by_number(components, source),
        relations=tuple(_relation(_table(one, source), source) for one in _list(model, "relations", source)),
        load_cases={
            _whole(case, source): {
                _whole(one, source): _attributes(one, source) for one in _list(case, "components", source)
            }
            for case in _list(spectrum, "load_cases", source)
        },
    )


def _component(table: Mapping[str, Any], source: str) -> RexsComponent:
    return RexsComponent(
        number_in_file=_whole(table, source),
        kind=str(table.get("type", "")),
        name=str(table.get("name", "")),
        attributes=_attributes(table, source),
        source=source,
    )


def _attributes(table: Any, source: str) -> dict[str, Attribute]:
    found = [_table(one, source) for one in _list(_table(table, source), "attributes", source)]
    return {str(one.get("id", "")): _attribute(one, source) for one in found}


def _attribute(table: Mapping[str, Any], source: str) -> Attribute:
    unit = str(table.get("unit", "none"))
    value = next((value for key, value in table.items() if key not in _ABOUT), "")
    if isinstance(value, bool):
        return Attribute(text="true" if value else "false", unit=unit)
    if not isinstance(value, list):
        return Attribute(text=str(value), unit=unit)
    if all(isinstance(one, int | float) for one in value):
        return Attribute(numbers=tuple(map(float, value)), unit=unit)
    return Attribute(unit=unit)  # texts and tables of numbers, none of which a scene asks for


def _relation(table: Mapping[str, Any], source: str) -> Relation:
    roles = {str(_table(ref, source).get("role", "")): _whole(ref, source) for ref in _list(table, "refs", source)}
    return Relation(kind=str(table.get("type", "")), roles=roles)


def _list(table: Mapping[str, Any], key: str, source: str) -> Sequence[Any]:
    value = table.get(key, [])
    if not isinstance(value, list):
        raise RexsError(f"{source}: {key} is {shown_value(value)}, and must be a list. Give a REXS file.")
    return value


def _table(value: Any, source: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise RexsError(f"{source}: {shown_value(value)} is in the place of a REXS object. Give a REXS file.")
    return value


def _whole(table: Any, source: str) -> int:
    value = _table(table, source).get("id")
    if isinstance(value, str) and value.isascii() and value.isdigit() and len(value) < 10:  # XML has texts
        value = int(value)
    if not isinstance(value, int) or isinstance(value, bool):
        raise RexsError(f"{source}: id = {shown_value(value)} must be a whole number. Correct it.")
    return value
