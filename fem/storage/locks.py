"""Locks on files, which the system releases whenever a process ends, so that no manual clean-up is needed."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import BinaryIO


def lock_file(file: BinaryIO, *, wait: bool = False) -> bool:
    """True if this process now has the lock, False if another has it; OSError if the file system has no locks."""
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(file.fileno(), msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except (BlockingIOError, PermissionError):
        return False
    return True


def same_file(file: BinaryIO, path: Path) -> bool:
    """False if the file was removed, and perhaps created again, between opening and locking."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    except FileNotFoundError:
        return False
