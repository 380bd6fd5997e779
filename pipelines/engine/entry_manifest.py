"""Manifest of a cache entry, the result of one step: its facts, size and checksum of each file; written last."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from fem.storage.cache_folder import MANIFEST, check_private
from pipelines.engine.storage import CONTENTS, ContentsError, reader

_KEY_LETTERS = 32  # of the hexadecimal SHA-256: short paths for Windows


class Damaged(Exception):
    """An entry is not what was stored."""


@dataclass(frozen=True)
class Entry:
    """A stored step: its folder and the facts that were stored with it."""

    folder: Path
    facts: Mapping[str, Any]
    bytes: int

    @property
    def name(self) -> str:
        """``<kind>-<key>``."""
        return self.folder.name


def entry_name(kind: str, key: str) -> str:
    """``<kind>-<first letters of the key>``."""
    return f"{kind}-{key[:_KEY_LETTERS]}"


def _file_digest(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_manifest(folder: Path, facts: Mapping[str, Any]) -> None:
    """Close an entry: its facts, and size and checksum of every file."""
    files = {
        path.relative_to(folder).as_posix(): {"bytes": path.stat().st_size, "sha256": _file_digest(path)}
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
    body = {"facts": facts, "files": files}
    text = json.dumps({"body": body, "sha256": _body_digest(body)})
    (folder / MANIFEST).write_text(text, encoding="utf-8")


def _body_digest(body: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(body, sort_keys=True).encode()).hexdigest()


def read_manifest(folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Facts and files of an entry.

    Raises
    ------
    Damaged : it is not a manifest that was written here
    """
    try:
        stored = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        body = stored["body"]
        if stored["sha256"] != _body_digest(body):
            raise Damaged(f"{MANIFEST} does not match its checksum")
        facts, files = body["facts"], body["files"]
        if entry_name(facts["kind"], facts["key"]) != folder.name:
            raise Damaged(f"{MANIFEST} belongs to another entry")
        sound = isinstance(facts, dict) and all(_names_a_file(name, given) for name, given in files.items())
    except FileNotFoundError:
        raise Damaged(f"{MANIFEST} is missing") from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise Damaged(f"{MANIFEST} cannot be read") from error
    if not sound:
        raise Damaged(f"{MANIFEST} was not written by gearcase")
    return facts, files


def _names_a_file(name: str, given: Mapping[str, Any]) -> bool:
    """True for a file in the folder of the entry, with its size and checksum."""
    parts = PurePosixPath(name).parts
    inside = bool(parts) and not any(part in ("/", "..") or set(part) & set("\\:") for part in parts)
    return inside and type(given["bytes"]) is int and isinstance(given["sha256"], str)


def verified(folder: Path, *, thorough: bool = True) -> Entry:
    """The entry in a folder. Not `thorough`: only the manifest is verified and the sizes of the files.

    Raises
    ------
    Damaged : the files are not those of the manifest, or name what they must not
    OSError : it cannot be read, or others can write in it
    """
    check_private(folder)
    facts, files = read_manifest(folder)
    for name, stored in files.items():
        path = folder / name
        try:
            if path.is_symlink():
                raise Damaged(f"{name} is a link")
            if path.stat().st_size != stored["bytes"]:
                raise Damaged(f"{name} has {path.stat().st_size} bytes, {stored['bytes']} were written")
            if thorough and _file_digest(path) != stored["sha256"]:
                raise Damaged(f"{name} does not match its checksum")
        except FileNotFoundError:
            raise Damaged(f"{name} is missing") from None
    if thorough and CONTENTS in files:
        try:
            reader(folder)
        except ContentsError as error:
            raise Damaged(str(error)) from error
    return Entry(folder, facts, sum(stored["bytes"] for stored in files.values()))
