"""Files that a user names: only regular files of limited size are read, and targets are checked before computing.

A name may be that of a folder, an endless device (``/dev/zero``), a pipe without a writer or a loop of links, or have
characters that no file name can have. Each of these raises an error before a file is opened or a result computed.
"""

from __future__ import annotations

import contextlib
import os
import re
import stat
import uuid
from collections.abc import Collection, Iterator
from pathlib import Path

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)

_UNSAFE = re.compile(r'[<>:"/\\|?*\x00-\x1f\x7f-\x9f\ud800-\udfff]')
_RESERVED = {"CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"}  # names of Windows, also with any suffix
_RESERVED |= {f"{port}{number}" for port in ("COM", "LPT") for number in "0123456789\u00b9\u00b2\u00b3"}


def checked_path(name: str | Path) -> Path:
    """The path of a name, if a file can have this name.

    Raises
    ------
    InputError : the name is empty, or has control characters or bytes that are not text
    """
    text = str(name)
    wrong = ""
    if not text:
        wrong = "a file name must not be empty"
    elif any(ord(c) < 0x20 or 0x7F <= ord(c) < 0xA0 for c in text):
        wrong = "a file name must not have control characters"
    elif any(0xD800 <= ord(c) < 0xE000 for c in text):
        wrong = "a file name must be UTF-8 text"
    if wrong:
        raise InputError(f'"{shown(text)}": {wrong}. Give another name.')
    return Path(text)


def folder_name(name: str) -> str:
    """The name of a scene as the name of a visible folder on every system; InputError if no character can be used."""
    safe = _UNSAFE.sub("_", name).strip(". ")
    if not safe or safe.partition(".")[0].rstrip().upper() in _RESERVED:
        raise InputError(
            f'"{shown(name)}": the file name cannot serve as the name of a result folder. '
            "Rename the file, as in my-scene.toml."
        )
    return safe


def is_regular_file(path: Path) -> bool:
    """True if there is a regular file of this name."""
    try:
        return stat.S_ISREG(os.stat(path).st_mode)
    except (OSError, ValueError):
        return False


def regular_file(path: Path, most_bytes: int | None = None) -> Path:
    """The path, if it is a regular file with at most `most_bytes` bytes.

    Raises
    ------
    FileNotFoundError : it does not exist
    InputError : it is not a regular file, is too large, or cannot be accessed
    """
    checked_path(path)
    try:
        found = os.stat(path)
    except FileNotFoundError:
        raise
    except OSError as error:
        raise _not_readable(path, error) from error
    kind = next((words for test, words in _KINDS if test(found.st_mode)), "")
    if not stat.S_ISREG(found.st_mode):
        raise InputError(f"{shown(path)}: is {kind or 'no regular file'}. Give a regular file.")
    if most_bytes is not None and found.st_size > most_bytes:
        raise InputError(
            f"{shown(path)}: has {found.st_size / 1e6:.1f} MB, at most {most_bytes / 1e6:g} MB are read. "
            "Give a smaller file."
        )
    return path


def read_text(path: Path, most_bytes: int) -> str:
    """The text of a small file: UTF-8, with or without a byte order mark.

    Raises
    ------
    FileNotFoundError : it does not exist
    InputError : it is not a regular file, cannot be read, is too large, or is not UTF-8
    """
    regular_file(path, most_bytes)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise _not_readable(path, error) from error
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError(f"{shown(path)}: not UTF-8 text (line {line}). Save the file as UTF-8.") from error


def _not_readable(path: Path, error: OSError) -> InputError:
    return InputError(f"{shown(path)}: cannot be read ({error.strerror}). Give a readable file.")


def sibling_names(path: Path, ending: str = "") -> list[str]:
    """Names of the files in the folder of `path`, for suggestions; none if it cannot be read."""
    try:
        return sorted(name for name in os.listdir(path.parent) if name.endswith(ending))
    except (OSError, ValueError):
        return []


def writable_file(name: str | Path, option: str = "--out", endings: Collection[str] = ()) -> Path:
    """The path of a file to write, checked before its content is computed.

    Parameters
    ----------
    name, option : of the file, and the option of the command line
    endings : allowed suffixes; empty: any

    Raises
    ------
    InputError : it is a folder, its folder cannot be written, or its suffix is not allowed
    """
    path = _writable(name, option, folder=False)
    if endings and path.suffix.lower() not in endings:
        known = " or ".join(endings)
        raise InputError(f"{option} {shown(name)}: the name must end in {known}. Correct the file name.")
    return path


def writable_folder(name: str | Path, option: str = "--out") -> Path:
    """The path of a folder for files to write, checked before their content is computed.

    Raises
    ------
    InputError : it is not a folder, or it cannot be made or written
    """
    return _writable(name, option, folder=True)


@contextlib.contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """A temporary path in the folder of `path`, with its suffix; it is renamed to `path` if the block raises no error.

    An interrupted computation or a full disk thus leaves the old file unchanged. Targets that are not regular files (a
    pipe, a device) and files in a folder without write permission are written directly.
    """
    final = Path(os.path.realpath(path))
    if final.exists() and not (final.is_file() and os.access(final.parent, os.W_OK)):
        yield final
        return
    final.parent.mkdir(parents=True, exist_ok=True)
    partial = final.with_name(f".{uuid.uuid4().hex}{final.suffix}")
    try:
        yield partial
        os.replace(partial, final)
    finally:
        partial.unlink(missing_ok=True)


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a text (UTF-8) or bytes completely, or leave the file unchanged."""
    with whole_file(path) as partial:
        partial.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)


def _writable(name: str | Path, option: str, *, folder: bool) -> Path:
    path = checked_path(name)
    if reason := _obstacle(path, folder=folder):
        raise InputError(f"{shown(name)}: cannot be written ({reason}). Choose another {option}.")
    return path


def _obstacle(path: Path, *, folder: bool) -> str:
    """Why a file (or a folder) cannot be written; "" if it can. Folders that do not exist are made later."""
    try:
        if path.exists() and not folder:
            there, wrong = path, "is a folder" if path.is_dir() else ""
        else:
            there = next(one for one in (path, *path.parents) if one.exists())
            wrong = "" if there.is_dir() else f"{shown(there)} is not a folder"
        return wrong or ("" if os.access(there, os.W_OK) else "no write permission")
    except OSError as error:
        return error.strerror or str(error)
