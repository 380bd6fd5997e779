"""Content-addressed store of finished steps, safe against kills, damage and a second process.

One entry is one folder ``entries/<kind>-<key>/`` with the files of a result and a manifest of their SHA-256. It is
written aside and moved into place in one step, so it is whole or absent; who loses a race throws its copy away.
What cannot be stored (read-only folder, full disk) is a warning, never a failure of the work. Whose the folder may be
and who may write in it: `fem.storage.cache_folder`. Nothing is removed that does not carry our manifest.
"""

from __future__ import annotations

import contextlib
import logging
import os
import shutil
import time
import uuid
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from fem.numerics import compiled_files
from fem.storage.cache_folder import (
    COMPILED,
    ENTRIES,
    MANIFEST,
    PARTIAL,
    UnusableFolder,
    cache_root,
    check_private,
    claim,
    is_entry,
    is_partial,
    make_private,
    warn_without,
)
from fem.storage.locks import lock_file, same_file
from pipelines.engine.manifest import Damaged, Entry, entry_name, read_manifest, verified, write_manifest
from pipelines.io.errors import CacheWarning, InputError

_LOG = logging.getLogger(__name__)
_STALE_SECONDS = 24 * 3600


class Cache:
    """The cache in one folder (the default one if none is given). Nothing is created before the first entry."""

    def __init__(self, folder: Path | str | None = None) -> None:
        self.folder = Path(folder).absolute() if folder is not None else cache_root()
        self._entries = self.folder / ENTRIES
        self._partial = self.folder / PARTIAL

    def find(self, kind: str, key: str, *, thorough: bool = True) -> Entry | None:
        """The entry, its checksums verified. A damaged one is removed with a warning and counts as absent.

        Not `thorough`: only the manifest is verified and the sizes of the files; enough to know what an entry holds,
        not to read it.
        """
        folder = self._entries / entry_name(kind, key)
        if not self._readable() or not folder.is_dir():
            return None
        try:
            entry = verified(folder, thorough=thorough)
            if entry.facts["key"] != key:
                raise Damaged("the key does not match")
        except Damaged as damage:
            self.discard(folder, str(damage))
            return None
        except OSError as error:
            warn_without(self.folder, error)
            return None
        try:
            os.utime(folder / MANIFEST)  # last use, for `clear --older-than`
        except OSError:
            _LOG.debug("cannot note the use of %s", folder.name)
        return entry

    def discard(self, folder: Path, damage: str) -> None:
        """Remove an entry that cannot be used, with a warning."""
        if folder.is_dir():  # else another process has just cleared it
            text = f"cache entry {folder.name} is damaged ({damage}). It is deleted and computed again."
            warnings.warn(CacheWarning(text), stacklevel=3)
            self._remove(folder)

    def store(
        self, kind: str, key: str, write: Callable[[Path], None], facts: Mapping[str, Any] | None = None
    ) -> Entry | None:
        """Let a function fill an empty folder, and keep it; None if the cache cannot take it.

        Parameters
        ----------
        kind, key : of the result, by which it is found
        write : fills the folder that it is given
        facts : of the result, to be read without it; as JSON takes them
        """
        final = self._entries / entry_name(kind, key)
        with self.workplace() as partial:
            if partial is None:
                return None
            try:
                make_private(self._entries)
                write(partial)
                write_manifest(partial, {**(facts or {}), "kind": kind, "key": key})
                try:
                    os.replace(partial, final)
                except OSError:
                    if not final.is_dir():
                        raise
                    _LOG.debug("%s was stored by another process", final.name)
                return verified(final)
            except OSError as error:
                warn_without(self.folder, error)
            except Damaged as damage:
                warn_without(self.folder, OSError(f"{final.name}: {damage}"))
        return None

    @contextlib.contextmanager
    def workplace(self) -> Iterator[Path | None]:
        """A folder beside the entries for what is made before it is stored; None, with a warning, if there is none."""
        folder = self._partial / f"{os.getpid()}-{uuid.uuid4().hex[:12]}"
        try:
            claim(self.folder, make=True)
            self._sweep()
            make_private(folder)
        except OSError as error:
            warn_without(self.folder, error)
            yield None
            return
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    @contextlib.contextmanager
    def alone(self, key: str) -> Iterator[bool]:
        """True while this process alone may build the result of a key, False if another one builds it.

        The system drops the right of a process that dies. Without locks, on some network file systems, a result may be
        built twice, which costs time alone.
        """
        path = self._partial / f"0-{key[:12]}"
        with contextlib.ExitStack() as held:
            mine = True
            try:
                claim(self.folder, make=True)
                make_private(self._partial)
                file = held.enter_context(open(path, "ab", buffering=0))
                mine = lock_file(file) and same_file(file, path)
                if mine:
                    held.callback(path.unlink, missing_ok=True)
            except FileNotFoundError:
                mine = False  # removed by who held it, between opening and looking
            except OSError as error:
                _LOG.debug("no locks in %s: %s", self.folder, error)
            yield mine

    def entries(self, kind: str | None = None) -> Iterator[Entry]:
        """All entries (of one kind) by their manifests, newest use first; files of results are not verified."""
        if not self._readable():
            return
        used = []
        for folder in self._entry_folders(f"{kind}-" if kind else ""):
            with contextlib.suppress(OSError):
                used.append(((folder / MANIFEST).stat().st_mtime, folder))
        for _, folder in sorted(used, reverse=True):
            try:
                facts, files = read_manifest(folder)
            except (OSError, Damaged):
                continue
            if kind is None or facts["kind"] == kind:
                yield Entry(folder, facts, sum(f["bytes"] for f in files.values()))

    def verify(self) -> tuple[int, list[str]]:
        """Check every entry; damaged ones are removed. Number of sound entries, and what was removed and why.

        Raises
        ------
        InputError : the folder is not ours
        """
        self._must_be_ours()
        sound, removed = 0, []
        for folder in self._entry_folders():
            try:
                verified(folder)
                sound += 1
            except (OSError, Damaged) as damage:
                removed.append(f"{folder.name}: {damage}")
                self._remove(folder)
        return sound, removed

    def clear(self, older_than_days: float = 0.0) -> tuple[int, int]:
        """Remove entries and compiled code that were not used for so many days. Their number and bytes.

        Raises
        ------
        InputError : the folder is not ours
        """
        self._must_be_ours()
        count = size = 0
        limit = time.time() - older_than_days * 86400
        for folder in self._entry_folders():
            if (folder / MANIFEST).stat().st_mtime <= limit:
                count, size = count + 1, size + sum(path.stat().st_size for path in folder.rglob("*"))
                self._remove(folder)
        for path in self.compiled():
            if path.stat().st_mtime <= limit:
                count, size = count + 1, size + path.stat().st_size
                path.unlink(missing_ok=True)
        self._sweep(min(_STALE_SECONDS, older_than_days * 86400))
        for folder in (self._entries, self._partial, self.folder / COMPILED):
            with contextlib.suppress(OSError):  # it is absent, or not empty
                folder.rmdir()
        return count, size

    def compiled(self) -> list[Path]:
        """The files of compiled code."""
        return list(compiled_files.files(self.folder / COMPILED)) if self._readable() else []

    def _entry_folders(self, prefix: str = "") -> list[Path]:
        """Folders that carry our manifest, their names beginning like that; whatever else there is stays as it is."""
        found = self._entries.iterdir() if self._entries.is_dir() else ()
        return sorted(folder for folder in found if folder.name.startswith(prefix) and is_entry(folder))

    def _readable(self) -> bool:
        """True if the folder is there and can be believed; it is said if it cannot."""
        try:
            claim(self.folder, make=False)
            check_private(self._entries)
        except FileNotFoundError:
            return self.folder.is_dir()
        except OSError as error:
            warn_without(self.folder, error)
            return False
        return True

    def _must_be_ours(self) -> None:
        try:
            claim(self.folder, make=False)
        except FileNotFoundError:
            return
        except UnusableFolder as error:
            raise InputError(f"the cache {self.folder} cannot be changed: {error}") from error

    def _remove(self, folder: Path) -> None:
        """Move aside in one step, then delete: no reader meets half an entry."""
        try:
            make_private(self._partial)
            aside = self._partial / f"removed-{uuid.uuid4().hex[:12]}"
            os.replace(folder, aside)
            shutil.rmtree(aside)
        except FileNotFoundError:
            _LOG.debug("%s was removed by another process", folder.name)
        except OSError as error:
            warn_without(self.folder, error)

    def _sweep(self, seconds: float = _STALE_SECONDS) -> None:
        """Delete what killed processes left behind so long ago."""
        for path in filter(is_partial, self._partial.iterdir()) if self._partial.is_dir() else ():
            try:
                last = max(one.stat().st_mtime for one in (path, *path.rglob("*")))
                if time.time() - last >= seconds:
                    if path.is_dir():
                        shutil.rmtree(path, ignore_errors=True)
                    else:
                        path.unlink(missing_ok=True)  # a right to build whose holder died, see `alone`
            except FileNotFoundError:
                _LOG.debug("%s was swept by another process", path.name)
