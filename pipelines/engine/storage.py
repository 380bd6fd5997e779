"""Storage and digests of results of steps: records, datasets, arrays, text, and trees of them.

A tree of dicts, lists, tuples and frozen dataclasses may contain records (`fem.storage.records.Record`), xarray
datasets, NumPy arrays, text, bytes, numbers, booleans and None. A loaded value is bitwise equal to the saved one.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import importlib
import json
import os
import re
import shutil
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fem.storage.large_array_file import StoredArray
from fem.storage.records import Record
from pipelines.engine.code_version import OWN_PACKAGES

CONTENTS = "contents.json"  # the table of contents of a stored value: a tree of nodes
DEPTH = 50
SHORT = 100  # longest array whose elements are compared one by one
LONG = 200  # characters of a text that is stored in a file of its own
_FILE = re.compile(r"part_\d+\.[a-z0-9]+")
_TYPE = re.compile(r"([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*):([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*)")


class ContentsError(ValueError):
    """The table of contents is not one that a step wrote."""


class StorageError(TypeError):
    """A value of this type cannot be stored."""


def save_value(folder: Path, value: Any) -> None:
    """Write `value` into an empty folder."""
    (folder / CONTENTS).write_text(json.dumps(_Files(folder).save(value)), encoding="utf-8")


def reader(folder: Path) -> Callable[[], Any]:
    """A function that reads a value of `save_value`; the whole table of contents is checked first.

    A damaged or manipulated table may be nested too deep, have wrong types, or name a file in another folder or a class
    of another program. Only modules of this program are imported for it; records of a user's program can be read if
    that program has imported them.

    Raises
    ------
    ContentsError : the table of contents is not valid
    OSError : the table cannot be read
    """
    try:
        return _reader(folder, json.loads((folder / CONTENTS).read_text(encoding="utf-8")), 0)
    except ContentsError:
        raise
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ContentsError(f"{CONTENTS} cannot be read") from error


def digest(value: Any) -> str:
    """SHA-256 digest of the content of a value, which does not depend on how it is stored."""
    return hashlib.sha256(json.dumps(_fingerprint(value), sort_keys=True).encode()).hexdigest()


def flat(value: Any, path: str = "") -> dict[str, Any]:
    """The leaves of a value by dotted path, with digests for records and large arrays; items of lists count from 1."""
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.size <= SHORT and np.isfinite(value).all():
        value = value.tolist()
    if isinstance(value, Record) or (_file_kind(value) and not isinstance(value, str)):
        return {path: digest(value)[:16]}
    if _is_dataclass(value):
        value = _fields(value)
    join = f"{path}." if path else ""
    if isinstance(value, Mapping):
        return {k: v for key, item in value.items() for k, v in flat(item, f"{join}{key}").items()}
    if isinstance(value, list | tuple):
        if all(isinstance(item, int | float | str | None) for item in value):
            return {path: [_plain(item) for item in value]}
        return {k: v for n, item in enumerate(value, 1) for k, v in flat(item, f"{join}{n}").items()}
    return {path: _plain(value)}


def class_modules(value: Any) -> set[str]:
    """Modules of the classes of this program in a value, since the result depends on their code."""
    found: set[str] = set()
    if _is_dataclass(value):
        found = {type(value).__module__} if type(value).__module__.partition(".")[0] in OWN_PACKAGES else set()
        value = _fields(value)
    if isinstance(value, Mapping):
        value = list(value.values())
    return found.union(*map(class_modules, value if isinstance(value, list | tuple) else ()))


class _Files:
    def __init__(self, folder: Path) -> None:
        self.folder, self.count = folder, 0

    def path(self, suffix: str) -> Path:
        self.count += 1
        return self.folder / f"part_{self.count}{suffix}"

    def linked(self, source: Path) -> str:
        """Add a file by a hard link, or by a copy if the file system has no hard links; its new name."""
        path = self.path(source.suffix)
        try:
            os.link(source, path)
        except OSError:
            shutil.copyfile(source, path)
        return path.name

    def save(self, value: Any) -> Any:
        """Write the parts of `value` to files; the node that describes the value."""
        if isinstance(value, Record):
            path = self.path(".h5")
            arrays = {name: self.linked(array.path) for name, array in value.stored_arrays().items()}
            value.save(path, without=arrays)
            return {"kind": "record", "type": _loadable(value), "file": path.name, "arrays": arrays}
        if kind := _file_kind(value):
            suffix, write, _ = _FILES[kind]
            path = self.path(suffix)
            write(path, value)
            return {"kind": kind, "file": path.name}
        if _is_dataclass(value):
            items = {f.name: self.save(getattr(value, f.name)) for f in dataclasses.fields(value) if f.init}
            return {"kind": "dataclass", "type": _loadable(value), "items": items}
        if isinstance(value, Mapping):
            return {"kind": "dict", "items": {key: self.save(value[key]) for key in _text_keys(value)}}
        if isinstance(value, list | tuple):
            kind = "list" if isinstance(value, list) else "tuple"
            return {"kind": kind, "items": [self.save(item) for item in value]}
        return {"kind": "plain", "value": _plain(value)}


def _reader(folder: Path, node: Any, depth: int) -> Callable[[], Any]:
    """The function that reads a node. A node can name only parts of the folder and classes that can be stored."""
    if depth > DEPTH:
        raise ContentsError(f"{CONTENTS} is nested more than {DEPTH} deep")
    match node.get("kind"):
        case "record":
            record, file = stored_class(node["type"], record=True), _file(folder, node["file"])
            arrays = {name: _file(folder, given) for name, given in node["arrays"].items()}
            return lambda: record.load(file, **{name: StoredArray(path) for name, path in arrays.items()})
        case "dataset" | "array" | "text" | "bytes" as kind:
            return functools.partial(_FILES[kind][2], _file(folder, node["file"]))
        case "dataclass":
            found = stored_class(node["type"], record=False)
            if set(node["items"]) != {f.name for f in dataclasses.fields(found) if f.init}:
                raise ContentsError(f"{node['type']} has other fields")
            values = _readers(folder, node, depth)
            return lambda: found(**{name: value() for name, value in values.items()})
        case "dict":
            values = _readers(folder, node, depth)
            return lambda: {name: value() for name, value in values.items()}
        case "list" | "tuple" as kind:
            items = [_reader(folder, item, depth + 1) for item in node["items"]]
            return lambda: (list if kind == "list" else tuple)(item() for item in items)
        case "plain":
            if not isinstance(value := node.get("value", ...), str | int | float | bool | None):
                raise ContentsError("a plain value is not plain")
            return lambda: value
    raise ContentsError("a part is of an unknown kind")


def _readers(folder: Path, node: Mapping[str, Any], depth: int) -> dict[str, Callable[[], Any]]:
    return {name: _reader(folder, item, depth + 1) for name, item in node["items"].items()}


def _load_dataset(path: Path) -> Any:
    import xarray

    return xarray.load_dataset(path, engine="h5netcdf")


_FILES: dict[str, tuple[str, Callable[[Path, Any], Any], Callable[[Path], Any]]] = {  # suffix, writer and reader
    "dataset": (".nc", lambda path, value: path.write_bytes(value.to_netcdf(engine="h5netcdf")), _load_dataset),
    "array": (".npy", functools.partial(np.save, allow_pickle=False), functools.partial(np.load, allow_pickle=False)),
    "text": (".txt", lambda path, value: path.write_bytes(value.encode()), lambda path: path.read_bytes().decode()),
    "bytes": (".bin", Path.write_bytes, Path.read_bytes),
}


def _file_kind(value: Any) -> str:
    """The kind of a value that is stored in a file, see `_FILES`; "" for other values."""
    if isinstance(value, str):
        return "text" if len(value) > LONG else ""
    if _is_dataset(value):
        return "dataset"
    return "array" if isinstance(value, np.ndarray) else "bytes" if isinstance(value, bytes) else ""


def _is_dataclass(value: Any) -> bool:
    return dataclasses.is_dataclass(value) and not isinstance(value, type)


def _fields(value: Any) -> dict[str, Any]:
    return {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}


def _file(folder: Path, name: str) -> Path:
    """The file in this folder that a node names."""
    if not _FILE.fullmatch(name):
        raise ContentsError(f"{name[:80]!r} is not the name of a part")
    if (folder / name).is_symlink() or not (folder / name).is_file():
        raise ContentsError(f"{name} is missing")
    return folder / name


def type_name(value: Any) -> str:
    """``module:class`` of a value."""
    return f"{type(value).__module__}:{type(value).__qualname__}"


def stored_class(name: str, *, record: bool) -> Any:
    """The class of a name: a record, or (not `record`) a frozen dataclass of this program.

    Raises
    ------
    ContentsError : there is no such class
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
    if not itself or not (issubclass(found, Record) if record else ours and dataclasses.is_dataclass(found)):
        raise ContentsError(f"{name[:80]} is not a {'record' if record else 'dataclass of gearcase'}")
    return found


def _fingerprint(value: Any) -> Any:
    if isinstance(value, Record):
        return ["record", value.digest()]
    if _is_dataset(value):
        parts = {
            str(name): [list(v.dims), _array_digest(v.values), _attributes(v.attrs)]
            for name, v in value.variables.items()
        }
        return ["dataset", parts, _attributes(value.attrs)]
    if isinstance(value, np.ndarray):
        return ["array", _array_digest(value)]
    if isinstance(value, bytes):
        return ["bytes", hashlib.sha256(value).hexdigest()]
    if _is_dataclass(value):
        items = {name: _fingerprint(item) for name, item in _fields(value).items()}
        return ["dataclass", type_name(value), items]
    if isinstance(value, Mapping):
        return ["dict", {key: _fingerprint(value[key]) for key in _text_keys(value)}]
    if isinstance(value, list | tuple):
        return ["list", [_fingerprint(item) for item in value]]
    return _plain(value)


def _plain(value: Any) -> Any:
    if isinstance(value, np.bool_ | np.integer | np.floating):
        return value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Path):
        return value.as_posix()
    raise StorageError(f"a {type(value).__name__} cannot be stored. Return records, datasets, arrays, text or numbers.")


def _array_digest(array: np.ndarray) -> str:
    if array.dtype.hasobject or array.dtype.kind in "UT":
        content, kind = json.dumps([str(item) for item in array.ravel()]).encode(), "text"
    else:
        content, kind = np.ascontiguousarray(array).tobytes(), array.dtype.str
    return hashlib.sha256(f"{kind}{array.shape}".encode() + content).hexdigest()


def _attributes(attributes: Mapping[Any, Any]) -> dict[str, str]:
    return {str(key): str(value) for key, value in attributes.items()}


def _is_dataset(value: Any) -> bool:
    return type(value).__module__.startswith("xarray") and hasattr(value, "to_netcdf")


def _text_keys(value: Mapping[Any, Any]) -> list[str]:
    if wrong := [key for key in value if not isinstance(key, str)]:
        raise StorageError(f"the keys of a table must be text, {wrong[0]!r} is not")
    return list(value)


def _loadable(value: Any) -> str:
    name = type_name(value)
    try:
        stored_class(name, record=isinstance(value, Record))
    except ContentsError as error:
        raise StorageError(f"a {type(value).__name__} cannot be stored: {error}") from error
    return name
