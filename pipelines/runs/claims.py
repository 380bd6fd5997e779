"""Claim on a result folder, taken when a run starts, so that two runs never write to the same folder.

A claim is the file ``.unfinished-<name>``. Only one process can create it, and it keeps the file locked until it ends.
The system releases the lock however the process ends. Thus files of a killed run are recognised without process
numbers, which are reused. Claims of another host are not touched, since some network file systems share no locks.

The files are written in the folder ``.partial-<name>``, which is renamed when the run ends, so a reader sees a complete
result or none. A folder that already exists (an empty one given by --out, a mounted volume) contains the claim itself.
The files are then moved one by one, the response last.
"""

from __future__ import annotations

import contextlib
import errno
import logging
import os
import platform
import shutil
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import BinaryIO

from fem.storage.locks import lock_file, same_file
from pipelines.io.errors import InputError, WorkError
from pipelines.io.shown_text import shown
from pipelines.io.user_files import writable_folder
from pipelines.runs.run_folder import RESPONSE, ROOT

_LOG = logging.getLogger(__name__)
_MARKER = ".unfinished-"
_PARTIAL = ".partial-"


@dataclass
class ClaimedFolder:
    """A result folder claimed by this process. Files are written to `folder`; `final` is where they are afterwards."""

    final: Path
    folder: Path
    marker: Path
    lock: BinaryIO


@contextlib.contextmanager
def claimed(name: str, out: str | Path | None = None, root: Path | None = None) -> Iterator[ClaimedFolder]:
    """Claim a folder: `out`, or a new one in ``<root>/<name>/`` with the time as its name; the default root is "runs".

    The folder exists only if the block ends without an error, and is then complete.

    Raises
    ------
    InputError : `out` is not empty, another run writes to it, or it cannot be written
    WorkError : the files cannot be moved; the message names the folder that contains them
    """
    try:
        claim = _claim_given(writable_folder(out)) if out is not None else _claim_new((root or ROOT) / name)
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            raise
        place = out if out is not None else (root or ROOT) / name
        raise InputError(
            f"{shown(place)}: results cannot be written ({error.strerror}). Choose another --out."
        ) from error
    try:
        yield claim
    except BaseException:
        shutil.rmtree(claim.folder, ignore_errors=True)
        raise
    else:
        _publish(claim)
    finally:
        _drop(claim.marker, claim.lock)


def _claim_new(parent: Path) -> ClaimedFolder:
    parent.mkdir(parents=True, exist_ok=True)
    _sweep(parent)
    names = _names(parent / time.strftime("%Y-%m-%d_%H-%M-%S"))
    return next(claim for final in names if (claim := _claim(final, parent)) is not None)


def _claim_given(final: Path) -> ClaimedFolder:
    place = final if final.is_dir() else final.parent
    place.mkdir(parents=True, exist_ok=True)
    _sweep(place)
    claim = _claim(final, place)
    if claim is not None:
        return claim
    marker, folder = _path_of(place, _MARKER, final), _path_of(place, _PARTIAL, final)
    if marker.exists():
        raise InputError(
            f"{shown(final)}: another run is writing there. Choose another --out. If no run is active on any "
            f"machine, delete the file {shown(marker)}."
        )
    if folder.exists():
        raise InputError(
            f"{shown(final)}: {shown(folder)} holds results that could not be moved there. Move or delete them."
        )
    raise InputError(
        f"{shown(final)}: exists and is not an empty folder. Choose another --out; nothing is overwritten."
    )


def _claim(final: Path, place: Path) -> ClaimedFolder | None:
    """The claim on a free name, with marker and files in `place`; None if the name is taken."""
    marker, folder = _path_of(place, _MARKER, final), _path_of(place, _PARTIAL, final)
    if _taken(final, place, marker):
        return None
    try:
        lock = open(marker, "x+b", buffering=0)  # noqa: SIM115 - open until the run ends
    except FileExistsError:
        return None
    try:
        try:
            lock_file(lock, wait=True)  # `_sweep` of another run may have locked it; it ignores an empty marker
        except OSError as error:
            _LOG.debug("%s: no locks here (%s), so it is never swept", marker, error)
        lock.write(_host())
        if not _taken(final, place, marker):
            folder.mkdir()
            return ClaimedFolder(final, folder, marker, lock)
    except FileExistsError:
        _LOG.debug("%s keeps results that could not be moved", folder)
    except BaseException:
        _drop(marker, lock)
        raise
    _drop(marker, lock)
    return None


def _taken(final: Path, place: Path, marker: Path) -> bool:
    """True if the name exists; if `place` is the result folder, true if it contains more than the marker."""
    if place != final:
        return os.path.lexists(final)
    return any(path != marker for path in final.iterdir())


def _publish(claim: ClaimedFolder) -> None:
    """Move the files to the result folder, or to the next free name if it was created meanwhile."""
    try:
        if claim.folder.parent == claim.final:
            for path in sorted(claim.folder.iterdir(), key=lambda path: path.name == RESPONSE):
                os.rename(path, claim.final / path.name)
            claim.folder.rmdir()
            return
        found = next(final for final in _names(claim.final) if _moved(claim.folder, final))
    except OSError as error:
        raise WorkError(
            f"{claim.final}: the results cannot be moved there ({error.strerror}). They are in {claim.folder}."
        ) from error
    if found != claim.final:
        _LOG.warning("%s was created by another process; the results are in %s", claim.final, found)
        claim.final = found


def _moved(folder: Path, final: Path) -> bool:
    """Rename a folder; False if the name is taken."""
    if os.path.lexists(final):
        return False
    try:
        os.rename(folder, final)
    except OSError:
        if not os.path.lexists(final):
            raise
        return False
    return True


def _names(first: Path) -> Iterator[Path]:
    yield first
    yield from (first.with_name(f"{first.name}_{number}") for number in count(2))


def _path_of(place: Path, prefix: str, final: Path) -> Path:
    return place / f"{prefix}{os.path.basename(os.path.abspath(final))}"


def _sweep(place: Path) -> None:
    """Remove the files of killed runs of this host."""
    for marker in place.glob(f"{_MARKER}*"):
        try:
            with open(marker, "r+b", buffering=0) as lock:
                if lock_file(lock) and lock.read() == _host() and same_file(lock, marker):
                    shutil.rmtree(place / marker.name.replace(_MARKER, _PARTIAL, 1), ignore_errors=True)
                    _drop(marker, lock)
        except OSError as error:  # the marker is of another user, or just removed, or there are no locks
            _LOG.debug("%s is left alone: %s", marker, error)


def _drop(marker: Path, lock: BinaryIO) -> None:
    """Remove a marker, then release its lock; in this order no marker of another process is removed."""
    if os.name == "nt":
        lock.close()  # Windows cannot remove an open file
    with contextlib.suppress(OSError):
        marker.unlink()
    lock.close()


def _host() -> bytes:
    return platform.node().encode()
