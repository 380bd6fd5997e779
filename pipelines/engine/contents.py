"""The table of contents of a stored result: a tree of nodes, checked before anything that it names is touched.

It is read from a folder, so it may be damaged or made up: too deep, of wrong types, naming a file elsewhere or a class
of another program. Nothing outside our packages is imported for it; records of a user's own program are known if that
program has imported them.
"""

from __future__ import annotations

import dataclasses
import importlib
import json
import re
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from fem.storage.records import Record
from pipelines.engine.code_version import OWN_PACKAGES

CONTENTS = "contents.json"
DEPTH = 50
_FILE = re.compile(r"part_\d+\.[a-z0-9]+")
_TYPE = re.compile(r"([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*):([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*)")


class ContentsError(ValueError):
    """A table of contents is not one that a step wrote."""


def read_contents(folder: Path) -> Mapping[str, Any]:
    """The root node, all of the tree checked.

    Raises
    ------
    ContentsError : it is not what it should be
    OSError : it cannot be read
    """
    try:
        node = json.loads((folder / CONTENTS).read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise ContentsError(f"{CONTENTS} cannot be read") from error
    _check(folder, node, 0)
    return node


def type_name(value: Any) -> str:
    """``module:class`` of a value."""
    return f"{type(value).__module__}:{type(value).__qualname__}"


def stored_class(name: str, *, record: bool) -> Any:
    """The class of this name: a record, or (not `record`) a frozen dataclass of our packages.

    Raises
    ------
    ContentsError : there is none
    """
    match = _TYPE.fullmatch(name)
    if match is None:
        raise ContentsError(f"{name[:80]!r} does not name a class")
    module, qualified = match.groups()
    ours = module.partition(".")[0] in OWN_PACKAGES
    try:
        found: Any = importlib.import_module(module) if ours else sys.modules.get(module)
    except ImportError as error:
        raise ContentsError(f"module {module} is not found") from error
    for part in qualified.split("."):
        found = getattr(found, part, None)
    itself = isinstance(found, type) and (found.__module__, found.__qualname__) == (module, qualified)
    if record and itself and issubclass(found, Record):
        return found
    if not record and itself and ours and dataclasses.is_dataclass(found):
        return found
    raise ContentsError(f"{name[:80]} is not a {'record' if record else 'dataclass of gearcase'}")


def _check(folder: Path, node: Any, depth: int) -> None:
    if depth > DEPTH:
        raise ContentsError(f"{CONTENTS} is nested more than {DEPTH} deep")
    inside: Iterable[Any] = ()
    match _table(node).get("kind"):
        case "record":
            stored_class(_text(node.get("type")), record=True)
            _check_file(folder, node.get("file"))
            for name in _table(node.get("arrays")).values():
                _check_file(folder, name)
        case "dataset" | "array" | "text" | "bytes":
            _check_file(folder, node.get("file"))
        case "dataclass":
            found = stored_class(_text(node.get("type")), record=False)
            if set(_table(node.get("items"))) != {f.name for f in dataclasses.fields(found) if f.init}:
                raise ContentsError(f"{node['type']} has other fields")
            inside = node["items"].values()
        case "dict":
            inside = _table(node.get("items")).values()
        case "list" | "tuple":
            inside = node.get("items")
            if not isinstance(inside, list):
                raise ContentsError("the items of a list are not a list")
        case "plain":
            if not isinstance(node.get("value", ...), str | int | float | bool | None):
                raise ContentsError("a plain value is not plain")
        case _:
            raise ContentsError("a part is of an unknown kind")
    for item in inside:
        _check(folder, item, depth + 1)


def _check_file(folder: Path, given: Any) -> None:
    name = _text(given)
    if not _FILE.fullmatch(name):
        raise ContentsError(f"{name[:80]!r} is not the name of a part")
    if (folder / name).is_symlink() or not (folder / name).is_file():
        raise ContentsError(f"{name} is missing")


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ContentsError(f"a {type(value).__name__} stands where a name should")
    return value


def _table(value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ContentsError(f"a {type(value).__name__} stands where a table should")
    return value
