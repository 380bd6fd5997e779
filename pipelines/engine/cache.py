"""Cache of finished steps, addressed by content, which interrupted or parallel processes and damage cannot corrupt.

One entry is one folder ``entries/<kind>-<key>/`` with the files of a result and a manifest of their SHA-256 digests.
It is written in a partial folder and renamed, so it is complete or absent; if two processes write the same entry, the
second discards its copy. If a result cannot be stored (read-only folder, full disk), the program warns and continues.
`fem.storage.cache_folder` checks the owner and permissions of the folder. Only entries with a manifest are removed.
The key, by which a stored result is valid, is made in `pipelines.engine.step`.
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
from pipelines.engine.entry_manifest import Damaged, Entry, entry_name, read_manifest, verified, write_manifest
from pipelines.io.errors import CacheWarning, InputError

_LOG = logging.getLogger(__name__)
_STALE_SECONDS = 24 * 3600


class Cache:
    """The cache in one folder (by default the cache folder of the user). The folder is created with the first entry."""

    def __init__(self, folder: Path | str | None = None) -> None:
        self.folder = Path(folder).absolute() if folder is not None else cache_root()
        self._entries = self.folder / ENTRIES
        self._partial = self.folder / PARTIAL

    def find(self, kind: str, key: str, *, thorough: bool = True) -> Entry | None:
        """The entry with verified checksums; None if it is absent. A damaged entry is removed with a warning.

        Without `thorough`, only the manifest and the sizes of the files are verified. This is sufficient to read the
        facts of an entry, but not its files.
        """
        folder = self._entries / entry_name(kind, key)
        if not self._readable() or not folder.is_dir():
            return None
        try:
            entry = verified(folder, thorough=thorough)
        except Damaged as damage:
            self.discard(folder, str(damage))
            return None
        except OSError as error:
            warn_without(self.folder, error)
            return None
        with contextlib.suppress(OSError):
            os.utime(folder / MANIFEST)  # last use, for `clear --older-than`
        return entry

    def discard(self, folder: Path, damage: str) -> None:
        """Remove an entry that cannot be used, with a warning."""
        if folder.is_dir():  # otherwise another process has just removed it
            text = f"cache entry {folder.name} is damaged ({damage}). It is deleted and computed again."
            warnings.warn(CacheWarning(text), stacklevel=3)
            self._remove(folder)

    def store(
        self, kind: str, key: str, write: Callable[[Path], None], facts: Mapping[str, Any] | None = None
    ) -> Entry | None:
        """Store the files that a function writes; None if the cache cannot store them.

        Parameters
        ----------
        kind, key : of the result, by which it is found
        write : writes the files to the empty folder that is its argument
        facts : of the result, stored as JSON, which can be read without its files
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
        """A folder on the file system of the entries for unfinished files; None, with a warning, if there is none."""
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
        """True while only this process may build the result of a key; False if another process builds it.

        The system releases the lock of a process that ends. On network file systems without locks, two processes may
        build the same result, which only takes more time.
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
                mine = False  # the holder of the lock removed the file after it was opened
            except OSError as error:
                _LOG.debug("no locks in %s: %s", self.folder, error)
            yield mine

    def entries(self, kind: str | None = None) -> Iterator[Entry]:
        """All entries (of one kind) by their manifests, latest use first; files of results are not verified."""
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
        """Check every entry and remove damaged ones; the number of undamaged entries, and each removal with its reason.

        Raises
        ------
        InputError : the folder is not a cache of this program
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
        """Remove entries and compiled code that were not used for some days; their number and bytes.

        Raises
        ------
        InputError : the folder is not a cache of this program
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
            with contextlib.suppress(OSError):  # the folder is absent, or not empty
                folder.rmdir()
        return count, size

    def compiled(self) -> list[Path]:
        """The files of compiled code in the cache."""
        return list(compiled_files.files(self.folder / COMPILED)) if self._readable() else []

    def _entry_folders(self, prefix: str = "") -> list[Path]:
        """Folders with a manifest whose names begin with a prefix; other folders are ignored."""
        found = self._entries.iterdir() if self._entries.is_dir() else ()
        return sorted(folder for folder in found if folder.name.startswith(prefix) and is_entry(folder))

    def _readable(self) -> bool:
        """True if the folder exists and is safe to read; a warning is given if it is not safe."""
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
        """Rename a folder, then delete it, so that no process reads a part of an entry."""
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
        """Delete files of killed processes that are older than some seconds."""
        for path in filter(is_partial, self._partial.iterdir()) if self._partial.is_dir() else ():
            with contextlib.suppress(FileNotFoundError):  # another process sweeps, too
                last = max(one.stat().st_mtime for one in (path, *path.rglob("*")))
                if time.time() - last >= seconds and path.is_dir():
                    shutil.rmtree(path, ignore_errors=True)
                elif time.time() - last >= seconds:
                    path.unlink(missing_ok=True)  # a lock file of `alone` whose process has ended
