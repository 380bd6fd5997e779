"""Content-addressed store of finished stages, safe against kills, damage and a second process.

One entry is one folder ``entries/<kind>-<key>/`` with payload files and a manifest that holds their SHA-256. An entry
is written aside and moved into place in one step, so it is whole or absent; who loses a race throws its copy away.
What cannot be stored (read-only folder, full disk) is a warning, never a failure of the work.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import logging
import os
import shutil
import time
import uuid
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipelines.errors import CacheWarning

_LOG = logging.getLogger(__name__)
_MANIFEST = "manifest.json"
_KEY_LETTERS = 32  # of the hexadecimal SHA-256: short paths for Windows
_STALE_SECONDS = 24 * 3600


class _Damaged(Exception):
    """An entry does not match its checksums."""


@dataclass(frozen=True)
class Entry:
    """A stored stage: its folder and the facts that were stored with it."""

    folder: Path
    facts: Mapping[str, Any]
    bytes: int

    @property
    def name(self) -> str:
        """``<kind>-<key>``."""
        return self.folder.name


def default_folder() -> Path:
    """GEARCASE_CACHE, or the user's cache folder of this system."""
    chosen = os.environ.get("GEARCASE_CACHE")
    if chosen:
        return Path(chosen)
    import platformdirs

    return Path(platformdirs.user_cache_dir("gearcase", appauthor=False))


class Cache:
    """The cache in one folder (the default one if none is given). Nothing is created before the first entry."""

    def __init__(self, folder: Path | str | None = None) -> None:
        self.folder = Path(folder) if folder is not None else default_folder()
        self._entries = self.folder / "entries"
        self._partial = self.folder / "partial"
        self._warned = False

    def find(self, kind: str, key: str, *, thorough: bool = True) -> Entry | None:
        """The entry, its checksums verified. A damaged one is removed with a warning and counts as absent.

        Not `thorough`: only the manifest is verified and the sizes of the files; enough to know what an entry holds,
        not to read it.
        """
        folder = self._entries / _entry_name(kind, key)
        if not folder.is_dir():
            return None
        try:
            entry = _verified(folder, thorough=thorough)
            if entry.facts.get("key") != key:
                raise _Damaged("the key does not match")
        except _Damaged as damage:
            if folder.is_dir():  # else another process has just cleared it
                warnings.warn(
                    CacheWarning(f"cache entry {folder.name} is damaged ({damage}). It is removed and built again."),
                    stacklevel=2,
                )
                self._remove(folder)
            return None
        except OSError as error:
            self.warn("read", error)
            return None
        try:
            os.utime(folder / _MANIFEST)  # last use, for `clear --older-than`
        except OSError:
            _LOG.debug("cannot note the use of %s", folder.name)
        return entry

    def store(
        self, kind: str, key: str, write: Callable[[Path], None], facts: Mapping[str, Any] | None = None
    ) -> Entry | None:
        """Let `write` fill an empty folder, and keep it under the key; None if the cache cannot take it."""
        final = self._entries / _entry_name(kind, key)
        partial = self._partial / f"{os.getpid()}-{uuid.uuid4().hex[:12]}"
        try:
            self._sweep()
            partial.mkdir(parents=True)
            self._entries.mkdir(parents=True, exist_ok=True)
            write(partial)
            _write_manifest(partial, {**(facts or {}), "kind": kind, "key": key})
            try:
                os.replace(partial, final)
            except OSError:
                if not final.is_dir():
                    raise
                _LOG.debug("%s was stored by another process", final.name)
            return _verified(final)
        except (OSError, _Damaged) as error:
            self.warn("write", error)
            return None
        finally:
            if partial.exists():
                shutil.rmtree(partial, ignore_errors=True)

    @contextlib.contextmanager
    def workplace(self) -> Iterator[Path | None]:
        """A folder beside the entries for what is made before it is stored; None, with a warning, if there is none."""
        folder = self._partial / f"{os.getpid()}-{uuid.uuid4().hex[:12]}"
        try:
            self._sweep()
            folder.mkdir(parents=True)
        except OSError as error:
            self.warn("write", error)
            yield None
            return
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def entries(self, kind: str | None = None) -> Iterator[Entry]:
        """All entries (of one kind) by their manifests, newest use first; payloads are not verified."""
        if not self._entries.is_dir():
            return
        prefix = f"{kind}-" if kind else ""
        found = []
        for folder in self._entries.iterdir():
            if not folder.name.startswith(prefix):
                continue
            try:
                facts, files = _read_manifest(folder)
                used = (folder / _MANIFEST).stat().st_mtime
            except (OSError, _Damaged):
                continue
            if kind is None or facts.get("kind") == kind:
                found.append((used, Entry(folder, facts, sum(f["bytes"] for f in files.values()))))
        yield from (entry for _, entry in sorted(found, key=lambda pair: -pair[0]))

    def verify(self) -> tuple[int, list[str]]:
        """Check every entry; damaged ones are removed. Number of sound entries, and what was removed and why."""
        sound, removed = 0, []
        for folder in sorted(self._entries.iterdir()) if self._entries.is_dir() else []:
            try:
                _verified(folder)
                sound += 1
            except (OSError, _Damaged) as damage:
                removed.append(f"{folder.name}: {damage}")
                self._remove(folder)
        return sound, removed

    def clear(self, older_than_days: float = 0.0) -> tuple[int, int]:
        """Remove entries that were not used for so many days. Their number and bytes."""
        count = size = 0
        limit = time.time() - older_than_days * 86400
        for entry in list(self.entries()):
            if (entry.folder / _MANIFEST).stat().st_mtime <= limit:
                count, size = count + 1, size + entry.bytes
                self._remove(entry.folder)
        if older_than_days == 0:
            for folder in (self._entries, self._partial):
                shutil.rmtree(folder, ignore_errors=True)
        return count, size

    def _remove(self, folder: Path) -> None:
        """Move aside in one step, then delete: no reader meets half an entry."""
        try:
            self._partial.mkdir(parents=True, exist_ok=True)
            aside = self._partial / f"removed-{uuid.uuid4().hex[:12]}"
            os.replace(folder, aside)
            shutil.rmtree(aside)
        except FileNotFoundError:
            _LOG.debug("%s was removed by another process", folder.name)
        except OSError as error:
            self.warn("write", error)

    def _sweep(self) -> None:
        """Delete what killed processes left behind long ago."""
        for folder in self._partial.iterdir() if self._partial.is_dir() else []:
            try:
                last = max(path.stat().st_mtime for path in (folder, *folder.rglob("*")))
                if time.time() - last > _STALE_SECONDS:
                    shutil.rmtree(folder, ignore_errors=True)
            except FileNotFoundError:
                _LOG.debug("%s was swept by another process", folder.name)

    def warn(self, verb: str, error: Exception) -> None:
        """Say, once, that the cache cannot be used."""
        if not self._warned:
            self._warned = True
            text = f"the cache {self.folder} cannot be used to {verb} ({error}); going on without it. "
            text += "Free space there, or set GEARCASE_CACHE to a folder that can be written."
            warnings.warn(CacheWarning(text), stacklevel=3)


def _entry_name(kind: str, key: str) -> str:
    return f"{kind}-{key[:_KEY_LETTERS]}"


def _file_digest(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _write_manifest(folder: Path, facts: Mapping[str, Any]) -> None:
    files = {
        path.relative_to(folder).as_posix(): {"bytes": path.stat().st_size, "sha256": _file_digest(path)}
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
    body = {"facts": facts, "files": files}
    text = json.dumps({"body": body, "sha256": _body_digest(body)})
    (folder / _MANIFEST).write_text(text, encoding="utf-8")


def _body_digest(body: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(body, sort_keys=True).encode()).hexdigest()


def _read_manifest(folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    try:
        stored = json.loads((folder / _MANIFEST).read_text(encoding="utf-8"))
        body = stored["body"]
        if stored["sha256"] != _body_digest(body):
            raise _Damaged(f"{_MANIFEST} does not match its checksum")
        return body["facts"], body["files"]
    except FileNotFoundError:
        raise _Damaged(f"{_MANIFEST} is missing") from None
    except (ValueError, KeyError, TypeError) as error:
        raise _Damaged(f"{_MANIFEST} cannot be read") from error


def _verified(folder: Path, *, thorough: bool = True) -> Entry:
    facts, files = _read_manifest(folder)
    for name, stored in files.items():
        path = folder / name
        try:
            if path.stat().st_size != stored["bytes"]:
                raise _Damaged(f"{name} has {path.stat().st_size} bytes, {stored['bytes']} were written")
            if thorough and _file_digest(path) != stored["sha256"]:
                raise _Damaged(f"{name} does not match its checksum")
        except FileNotFoundError:
            raise _Damaged(f"{name} is missing") from None
    return Entry(folder, facts, sum(stored["bytes"] for stored in files.values()))
