"""The cache folder for reproducible results: its location, and checks that only its owner can write in it.

Its content is trusted: stored results replace computations, compiled code is executed. Every folder in it is therefore
private to its owner. A folder made or writable by another user is refused with the reason. Root may write everywhere
and is trusted, so that an administrator can fill a cache for others to read. Systems other than POSIX protect the
user's folders themselves; there the owner is not checked.
"""

from __future__ import annotations

import contextlib
import os
import re
import stat
import uuid
import warnings
from pathlib import Path

ENTRIES, PARTIAL, COMPILED = FOLDERS = ("entries", "partial", "compiled")
MANIFEST = "manifest.json"
ENTRY_NAME = re.compile(r"[^/\\]+-[0-9a-f]{32}")  # <kind>-<first letters of the key>
PARTIAL_NAME = re.compile(r"(\d+|removed)-[0-9a-f]{12}")
MARK = "CACHEDIR.TAG"  # its first line marks a cache for backup programs (bford.info/cachedir)
_SIGNATURE = "Signature: 8a477f597d28d172789f06886806bc55"
_OURS = "# A cache of gearcase."
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH

_said: set[str] = set()


class CacheWarning(UserWarning):
    """The cache could not be used (damaged entry, folder not writable); results are not affected."""


class UnusableFolder(OSError):
    """A folder belongs to another user or purpose, or others can write in it."""


def cache_root() -> Path:
    """GEARCASE_CACHE, or the user's cache folder of this system."""
    chosen = os.environ.get("GEARCASE_CACHE")
    if chosen:
        return Path(chosen).absolute()
    import platformdirs

    return Path(platformdirs.user_cache_dir("gearcase", appauthor=False))


def claim(root: Path, *, make: bool) -> None:
    """Check that a root is a cache of gearcase that only its owner can write in; `make` it if it is missing.

    An empty folder becomes one, and so does a root without a mark that contains only results of gearcase.

    Raises
    ------
    FileNotFoundError : it is missing and not to be made
    UnusableFolder : it belongs to another user or to another purpose
    OSError : it cannot be created or read
    """
    if not root.is_absolute():
        raise UnusableFolder(f"there is no home folder for {root}")
    if make and not root.exists():
        make_private(root)
    if _marked(root):
        check_private(root)
        return
    own = os.name == "posix" and root.stat().st_uid == os.geteuid()
    if own and not any(root.iterdir()) and not _of_group(root.stat()):
        root.chmod(0o700)
    check_private(root)
    strangers = _strangers(root)
    if strangers and not _marked(root):  # not marked by another process in between
        raise UnusableFolder(f"it holds {strangers[0]}, which is not a file of gearcase; set a new or an empty folder")
    try:
        _mark(root)
    except OSError:
        if make:
            raise


def make_private(folder: Path) -> None:
    """Make a folder and its missing parents private to the owner; an existing folder is checked.

    Raises
    ------
    UnusableFolder : it exists and others can write in it
    OSError : it cannot be made
    """
    if not folder.parent.exists():
        make_private(folder.parent)
    with contextlib.suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    check_private(folder)


def check_private(folder: Path) -> None:
    """Raise UnusableFolder unless only the owner (this user or root) can write in a folder."""
    status = folder.stat()
    reason = distrust(status)
    if reason and _of_group(status):
        raise UnusableFolder(
            f"{folder} is shared by a group (mode {stat.S_IMODE(status.st_mode):o}), whose members could place code in "
            f"it that you would run. To share its disk: chmod +t {folder}, and every user sets GEARCASE_CACHE to a "
            f"separate folder in it, as {folder}/NAME. To share results: root fills a cache that others only read, "
            "see Sharing in docs/cache.md"
        )
    if reason:
        raise UnusableFolder(f"{folder} {reason}")


def distrust(status: os.stat_result) -> str:
    """The reason why another user may have written a file of this status; "" if only this user or root can."""
    if os.name != "posix":
        return ""
    if status.st_uid not in (os.geteuid(), 0):
        return f"belongs to another user (number {status.st_uid})"
    if status.st_mode & _OTHERS_WRITE:
        mode = stat.S_IMODE(status.st_mode)
        return f"can be written by other users (mode {mode:o}); if none of them did, chmod -R go-w it"
    return ""


def warn_without(root: Path, error: OSError) -> None:
    """Warn, once in a process, that a cache is not used, with the reason. The text is the same in every process."""
    reason = error.strerror or str(error)
    warn_once(
        f"the cache {root} cannot be used ({reason}). Work continues without it: results are not kept, and code is "
        "compiled again in every process, which takes about 20 seconds. Free space there, or set "
        "GEARCASE_CACHE to a folder that can be "
        "written and is yours alone."
    )


def warn_once(text: str) -> None:
    """Issue a CacheWarning, unless this process has issued the same before."""
    if text not in _said:
        _said.add(text)
        warnings.warn(CacheWarning(text), stacklevel=3)


def _of_group(status: os.stat_result) -> bool:
    """Whether a group shares a folder: new files inherit its group, and the group can write in it."""
    shared = stat.S_ISGID | stat.S_IWGRP
    return os.name == "posix" and status.st_mode & shared == shared


def _marked(root: Path) -> bool:
    try:
        lines = (root / MARK).read_text(encoding="utf-8", errors="replace").splitlines()
    except FileNotFoundError:
        return False
    return len(lines) > 1 and lines[0] == _SIGNATURE and lines[1].startswith(_OURS)


def _mark(root: Path) -> None:
    """Mark a root in one step, from a private folder, so that a simultaneous process sees no unknown file."""
    make_private(root / PARTIAL)
    aside = root / PARTIAL / f"{os.getpid()}-{uuid.uuid4().hex[:12]}"
    try:
        text = f"{_SIGNATURE}\n{_OURS} Everything in it can be made again.\n"
        aside.write_text(text, encoding="utf-8", newline="\n")
        os.replace(aside, root / MARK)
    finally:
        aside.unlink(missing_ok=True)


def _strangers(root: Path) -> list[str]:
    """Content of a root without a mark that is not from gearcase."""
    found = [path.name for path in root.iterdir() if path.name not in FOLDERS or path.is_symlink()]
    for folder, kept in ((ENTRIES, is_entry), (PARTIAL, is_partial)):
        inside = (root / folder).iterdir() if (root / folder).is_dir() else ()
        found += [f"{folder}/{path.name}" for path in inside if not kept(path)]
    return sorted(found)


def is_entry(folder: Path) -> bool:
    """True for a folder named like a stored result with a manifest of gearcase, damaged or not."""
    named = ENTRY_NAME.fullmatch(folder.name) is not None
    return named and not folder.is_symlink() and (folder / MANIFEST).is_file()


def is_partial(path: Path) -> bool:
    """True for the name of an entry that is being written or removed."""
    return PARTIAL_NAME.fullmatch(path.name) is not None and not path.is_symlink()
