"""The folder of everything that can be made again: where it is, that it is ours, and that nobody else can write in it.

What is in it is believed: stored results are taken for computed ones, compiled code is run. So every folder in it is
made for its owner alone, and a folder that another user made, or can write in, is refused with the reason. Root may
write everywhere and is believed; so an administrator can fill a cache for others to read. Systems other than POSIX
guard the user's own folders by themselves; there the owner is not looked at.
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
MARK = "CACHEDIR.TAG"  # by its first line programs that make backups know a cache (bford.info/cachedir)
_SIGNATURE = "Signature: 8a477f597d28d172789f06886806bc55"
_OURS = "# A cache of gearcase."
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH

_said: set[str] = set()


class CacheWarning(UserWarning):
    """The cache could not do its part (damaged entry, folder not writable); results are not affected."""


class UnusableFolder(OSError):
    """A folder is not ours, or others can write in it."""


def cache_root() -> Path:
    """GEARCASE_CACHE, or the user's cache folder of this system."""
    chosen = os.environ.get("GEARCASE_CACHE")
    if chosen:
        return Path(chosen).absolute()
    import platformdirs

    return Path(platformdirs.user_cache_dir("gearcase", appauthor=False))


def claim(root: Path, *, make: bool) -> None:
    """Check that a root is a cache of gearcase that nobody else can write in; `make` it if it is absent.

    An empty folder becomes one, and so does a root without a mark that holds nothing but what gearcase stores.

    Raises
    ------
    FileNotFoundError : it is absent and not to be made
    UnusableFolder : it belongs to another user or to another purpose
    OSError : it cannot be made or read
    """
    if not root.is_absolute():
        raise UnusableFolder(f"there is no home folder for {root}")
    if make and not root.exists():
        make_private(root)
    if _marked(root):
        check_private(root)
        return
    if not any(root.iterdir()) and _own(root.stat()) and not _of_group(root.stat()):
        root.chmod(0o700)
    check_private(root)
    strangers = _strangers(root)
    if strangers and not _marked(root):  # by another process since
        raise UnusableFolder(f"it holds {strangers[0]}, which is not a file of gearcase; set a new or an empty folder")
    try:
        _mark(root)
    except OSError:
        if make:
            raise


def make_private(folder: Path) -> None:
    """Make a folder, and those above it that are missing, for its owner alone; one that is there is checked.

    Raises
    ------
    UnusableFolder : it is there and others can write in it
    OSError : it cannot be made
    """
    if not folder.parent.exists():
        make_private(folder.parent)
    with contextlib.suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    check_private(folder)


def check_private(folder: Path) -> None:
    """Raises UnusableFolder if someone else than its owner (this user or root) can write in a folder."""
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
    """Why another user may have written what has this status; "" if only this user or root can have."""
    if os.name != "posix":
        return ""
    if status.st_uid not in (os.geteuid(), 0):
        return f"belongs to another user (number {status.st_uid})"
    if status.st_mode & _OTHERS_WRITE:
        mode = stat.S_IMODE(status.st_mode)
        return f"can be written by other users (mode {mode:o}); if none of them did, chmod -R go-w it"
    return ""


def warn_without(root: Path, error: OSError) -> None:
    """Say, once in a process, that a cache is not used and why. The words are the same in every process."""
    reason = error.strerror or str(error)
    warn_once(
        f"the cache {root} cannot be used ({reason}). Work continues without it: results are not kept, and code is "
        "compiled again in every process, which takes a minute or more. Free space there, or set "
        "GEARCASE_CACHE to a folder that can be "
        "written and is yours alone."
    )


def warn_once(text: str) -> None:
    """A CacheWarning, unless this process gave the same before."""
    if text not in _said:
        _said.add(text)
        warnings.warn(CacheWarning(text), stacklevel=3)


def _of_group(status: os.stat_result) -> bool:
    """Whether a folder is meant to be shared by a group: it hands its group down, and the group can write in it."""
    shared = stat.S_ISGID | stat.S_IWGRP
    return os.name == "posix" and status.st_mode & shared == shared


def _own(status: os.stat_result) -> bool:
    return os.name == "posix" and status.st_uid == os.geteuid()


def _marked(root: Path) -> bool:
    try:
        lines = (root / MARK).read_text(encoding="utf-8", errors="replace").splitlines()
    except FileNotFoundError:
        return False
    return len(lines) > 1 and lines[0] == _SIGNATURE and lines[1].startswith(_OURS)


def _mark(root: Path) -> None:
    """In one step, by way of a folder that is ours: a second process at the same moment sees no stranger."""
    make_private(root / PARTIAL)
    aside = root / PARTIAL / f"{os.getpid()}-{uuid.uuid4().hex[:12]}"
    try:
        text = f"{_SIGNATURE}\n{_OURS} Everything in it can be made again.\n"
        aside.write_text(text, encoding="utf-8", newline="\n")
        os.replace(aside, root / MARK)
    finally:
        aside.unlink(missing_ok=True)


def _strangers(root: Path) -> list[str]:
    """What a root without a mark holds beyond what gearcase stores."""
    found = [path.name for path in root.iterdir() if path.name not in FOLDERS or path.is_symlink()]
    for folder, kept in ((ENTRIES, is_entry), (PARTIAL, is_partial)):
        inside = (root / folder).iterdir() if (root / folder).is_dir() else ()
        found += [f"{folder}/{path.name}" for path in inside if not kept(path)]
    return sorted(found)


def is_entry(folder: Path) -> bool:
    """True for a folder named like a stored result that carries our manifest, damaged or not."""
    named = ENTRY_NAME.fullmatch(folder.name) is not None
    return named and not folder.is_symlink() and (folder / MANIFEST).is_file()


def is_partial(path: Path) -> bool:
    """True for what is named like something being written or removed."""
    return PARTIAL_NAME.fullmatch(path.name) is not None and not path.is_symlink()
