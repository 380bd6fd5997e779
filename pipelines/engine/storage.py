"""Save, load and fingerprint what a step returns: records, datasets, arrays, text, and trees of them.

A tree of dicts, lists, tuples and frozen dataclasses may hold records (`fem.storage.records.Record`), xarray datasets,
numpy arrays, text, bytes, numbers, booleans and None. What is loaded has the same bits as what was saved.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fem.storage.records import Record
from fem.storage.stored_array import StoredArray
from pipelines.engine.code_version import OWN_PACKAGES
from pipelines.engine.contents import CONTENTS, ContentsError, read_contents, stored_class, type_name

SHORT = 100  # numbers of an array that are told one by one


class StorageError(TypeError):
    """A value is of a kind that cannot be stored."""


def save_value(folder: Path, value: Any) -> None:
    """Write `value` into the empty folder."""
    files = _Files(folder)
    node = files.save(value)
    (folder / CONTENTS).write_text(json.dumps(node), encoding="utf-8")


def load_value(folder: Path) -> Any:
    """Read what `save_value` wrote.

    Raises
    ------
    OSError, ValueError : a file is missing or not what it should be
    """
    return _load(folder, read_contents(folder))


def digest(value: Any) -> str:
    """SHA-256 of the content of a value, independent of how it is stored."""
    return hashlib.sha256(json.dumps(_fingerprint(value), sort_keys=True).encode()).hexdigest()


def flat(value: Any, path: str = "") -> dict[str, Any]:
    """The plain leaves of a value by dotted path, but records and large arrays by their digest; items of lists are
    counted from 1."""
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.size <= SHORT and np.isfinite(value).all():
        value = value.tolist()
    if isinstance(value, Record) or _is_dataset(value) or isinstance(value, np.ndarray | bytes):
        return {path: digest(value)[:16]}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
    elif hasattr(value, "model_dump"):
        value = value.model_dump(mode="json")
    join = f"{path}." if path else ""
    if isinstance(value, Mapping):
        return {k: v for key, item in value.items() for k, v in flat(item, f"{join}{key}").items()}
    if isinstance(value, list | tuple):
        if all(isinstance(item, int | float | str | None) for item in value):
            return {path: [_plain(item) for item in value]}
        return {k: v for n, item in enumerate(value, 1) for k, v in flat(item, f"{join}{n}").items()}
    return {path: _plain(value)}


def class_modules(value: Any) -> set[str]:
    """Modules of the classes of ours in a value: a spec with a rope in it hangs on the code of the rope."""
    found: set[str] = set()
    parts: Iterable[Any] = ()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        parts = [getattr(value, field.name) for field in dataclasses.fields(value)]
        found = {type(value).__module__} if type(value).__module__.partition(".")[0] in OWN_PACKAGES else set()
    elif isinstance(value, Mapping):
        parts = value.values()
    elif isinstance(value, list | tuple):
        parts = value
    return found.union(*map(class_modules, parts))


class _Files:
    def __init__(self, folder: Path) -> None:
        self.folder, self.count = folder, 0

    def path(self, suffix: str) -> Path:
        self.count += 1
        return self.folder / f"part_{self.count}{suffix}"

    def linked(self, source: Path) -> str:
        """Take a file in by a second name, or a copy where the file system knows no second names; its name here."""
        path = self.path(source.suffix)
        try:
            os.link(source, path)
        except OSError:
            shutil.copyfile(source, path)
        return path.name

    def save(self, value: Any) -> Any:
        """Write the parts of `value` to files; the node that describes them."""
        if isinstance(value, Record):
            path = self.path(".h5")
            arrays = {name: self.linked(array.path) for name, array in value.stored_arrays().items()}
            value.save(path, without=arrays)
            return {"kind": "record", "type": _loadable(value), "file": path.name, "arrays": arrays}
        if _is_dataset(value):
            path = self.path(".nc")
            path.write_bytes(value.to_netcdf(engine="h5netcdf"))
            return {"kind": "dataset", "file": path.name}
        if isinstance(value, np.ndarray):
            path = self.path(".npy")
            np.save(path, value, allow_pickle=False)
            return {"kind": "array", "file": path.name}
        if isinstance(value, str) and len(value) > 200:
            path = self.path(".txt")
            path.write_bytes(value.encode())
            return {"kind": "text", "file": path.name}
        if isinstance(value, bytes):
            path = self.path(".bin")
            path.write_bytes(value)
            return {"kind": "bytes", "file": path.name}
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            items = {f.name: self.save(getattr(value, f.name)) for f in dataclasses.fields(value) if f.init}
            return {"kind": "dataclass", "type": _loadable(value), "items": items}
        if isinstance(value, Mapping):
            _only_text_keys(value)
            return {"kind": "dict", "items": {key: self.save(item) for key, item in value.items()}}
        if isinstance(value, list | tuple):
            kind = "list" if isinstance(value, list) else "tuple"
            return {"kind": kind, "items": [self.save(item) for item in value]}
        return {"kind": "plain", "value": _plain(value)}


def _load(folder: Path, node: Mapping[str, Any]) -> Any:
    match node["kind"]:
        case "record":
            arrays = {name: StoredArray(folder / file) for name, file in node["arrays"].items()}
            return stored_class(node["type"], record=True).load(folder / node["file"], **arrays)
        case "dataset":
            import xarray

            return xarray.load_dataset(folder / node["file"], engine="h5netcdf")
        case "array":
            return np.load(folder / node["file"], allow_pickle=False)
        case "text":
            return (folder / node["file"]).read_bytes().decode()
        case "bytes":
            return (folder / node["file"]).read_bytes()
        case "dataclass":
            made = stored_class(node["type"], record=False)
            return made(**{name: _load(folder, item) for name, item in node["items"].items()})
        case "dict":
            return {name: _load(folder, item) for name, item in node["items"].items()}
        case "list":
            return [_load(folder, item) for item in node["items"]]
        case "tuple":
            return tuple(_load(folder, item) for item in node["items"])
    return node["value"]


def _fingerprint(value: Any) -> Any:
    if isinstance(value, Record):
        return ["record", value.digest()]
    if _is_dataset(value):
        parts = {
            str(name): [list(v.dims), _array_digest(v.values), _text(v.attrs)] for name, v in value.variables.items()
        }
        return ["dataset", parts, _text(value.attrs)]
    if isinstance(value, np.ndarray):
        return ["array", _array_digest(value)]
    if isinstance(value, bytes):
        return ["bytes", hashlib.sha256(value).hexdigest()]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        items = {f.name: _fingerprint(getattr(value, f.name)) for f in dataclasses.fields(value)}
        return ["dataclass", type_name(value), items]
    if hasattr(value, "model_dump"):
        return ["model", type(value).__name__, value.model_dump(mode="json")]
    if isinstance(value, Mapping):
        _only_text_keys(value)
        return ["dict", {key: _fingerprint(item) for key, item in value.items()}]
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
        content = json.dumps([str(item) for item in array.ravel()]).encode()
        kind = "text"
    else:
        content, kind = np.ascontiguousarray(array).tobytes(), array.dtype.str
    return hashlib.sha256(f"{kind}{array.shape}".encode() + content).hexdigest()


def _text(attributes: Mapping[Any, Any]) -> dict[str, str]:
    return {str(key): str(value) for key, value in attributes.items()}


def _is_dataset(value: Any) -> bool:
    return type(value).__module__.startswith("xarray") and hasattr(value, "to_netcdf")


def _only_text_keys(value: Mapping[Any, Any]) -> None:
    wrong = [key for key in value if not isinstance(key, str)]
    if wrong:
        raise StorageError(f"the keys of a table must be text, {wrong[0]!r} is not")


def _loadable(value: Any) -> str:
    name = type_name(value)
    try:
        stored_class(name, record=isinstance(value, Record))
    except ContentsError as error:
        raise StorageError(f"a {type(value).__name__} cannot be stored: {error}") from error
    return name
