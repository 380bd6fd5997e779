"""Files of compiled code, which are read only if this user or root wrote them and no byte has changed.

They are in the cache folder, or in the folder `gearcase` of NUMBA_CACHE_DIR if that is set. The program executes the
code it reads, so the owner of the open file is checked, not only those of the folders above it. If the files cannot
be written or read, the program warns once and compiles in memory. Functions are compiled in `fem.numerics.compiled`.

A process that compiles a function holds a lock on it, so that other processes wait for its file instead of compiling
the function, too.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from fem.storage.cache_folder import (
    COMPILED,
    UnusableFolder,
    cache_root,
    check_private,
    claim,
    distrust,
    make_private,
    warn_once,
    warn_without,
)
from fem.storage.locks import lock_file, same_file

_FIRST_LINE = b"gearcase compiled code\n"
_DIGEST_BYTES = 32


def compiled_folder() -> Path:
    """Folder of the compiled code, which need not exist."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    return Path(chosen).absolute() / "gearcase" if chosen else cache_root() / COMPILED


def read(name: str, key: str) -> bytes | None:
    """The content that was written under a name and a key; None if it is absent, damaged or of another user."""
    folder = compiled_folder()
    try:
        _prepare(folder, make=False)
        with open(folder / name, "rb") as file:
            reason = distrust(os.fstat(file.fileno()))
            if reason:
                raise UnusableFolder(f"{folder / name} {reason}")
            head, content = file.read(len(_FIRST_LINE) + _DIGEST_BYTES), file.read()
    except FileNotFoundError:
        return None
    except OSError as error:
        warn_without(_root(folder), error)
        return None
    if head != _head(key, content):
        warn_once(f"compiled code {folder / name} is damaged. It is compiled again.")
        return None
    with contextlib.suppress(OSError):  # the file may belong to root
        os.utime(folder / name)  # last use, for `gearcase cache clear --older-than`
    return content


def write(name: str, key: str, content: bytes) -> None:
    """Store `content` under a name and a key; a warning is given if that is not possible."""
    folder = compiled_folder()
    try:
        _prepare(folder, make=True)
        number, partial = tempfile.mkstemp(prefix="part-", dir=folder)
        try:
            with open(number, "wb") as file:
                file.write(_head(key, content) + content)
            os.replace(partial, folder / name)
        except BaseException:
            os.unlink(partial)
            raise
    except OSError as error:
        warn_without(_root(folder), error)


def lock(name: str) -> BinaryIO | None:
    """Wait until no other process compiles the code of a name; the lock, or None where there are no locks.

    `unlock` releases it, or the system does when this process ends.
    """
    folder = compiled_folder()
    path = folder / f"{name}.lock"
    try:
        _prepare(folder, make=True)
        while True:
            file = open(path, "wb")  # noqa: SIM115
            if lock_file(file, wait=True) and same_file(file, path):
                return file
            file.close()
    except OSError:  # `write` reports what is wrong with the folder
        return None


def unlock(file: BinaryIO) -> None:
    """Release a lock, and remove its file."""
    with contextlib.suppress(OSError):  # an open file cannot be removed on every system
        os.unlink(file.name)
    file.close()


def files(folder: Path) -> Iterator[Path]:
    """The files of a folder that hold compiled code of this program, complete or not."""
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        if path.is_file() and not path.is_symlink():
            with open(path, "rb") as file:
                if file.read(len(_FIRST_LINE)) == _FIRST_LINE:
                    yield path


def _prepare(folder: Path, *, make: bool) -> None:
    if _root(folder) != folder:
        claim(_root(folder), make=make)
    if make:
        make_private(folder)
    else:
        check_private(folder)


def _root(folder: Path) -> Path:
    """The cache that contains the folder, or the folder itself."""
    return folder.parent if folder.parent == cache_root() else folder


def _head(key: str, content: bytes) -> bytes:
    return _FIRST_LINE + hashlib.sha256(key.encode() + b"\n" + content).digest()
