"""HDF5 files, written so that a full disk raises OSError.

If the disk becomes full while the HDF5 library writes, the library cannot close its objects, which may end the process.
The library therefore never writes to the disk itself, but through `careful_file`.
"""

from __future__ import annotations

import contextlib
import io
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import h5py


@contextlib.contextmanager
def careful_file(path: Path | str) -> Iterator[CarefulFile]:
    """A new file that the HDF5 library may write to; it gets the name `path` when the block ends without error.

    Call `check` of a large file after every block of data.

    Raises
    ------
    OSError : the file cannot be written
    """
    path = Path(path)
    partial = path.with_name(f"{path.name}.partial")
    try:
        with open(partial, "w+b", buffering=0) as file:
            careful = CarefulFile(file)
            yield careful
            careful.check()
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def blocks_missing(dataset: h5py.Dataset) -> str:
    """Text for a dataset whose stored blocks are incomplete; "" if it is complete.

    HDF5 reads blocks that are not in the file as zeros. A damaged length takes minutes to read.
    """
    if dataset.chunks is None:
        return ""
    needed = math.prod(-(-length // block) for length, block in zip(dataset.shape, dataset.chunks, strict=True))
    stored = dataset.id.get_num_chunks()
    if stored >= needed:
        return ""
    shape = " x ".join(map(str, dataset.shape))
    return f"has {shape} values by its header, but the file holds {stored} of {needed} blocks of values"


class CarefulFile(io.RawIOBase):
    """A file that postpones errors of writing: data that do not fit on the disk stay in memory until `check`."""

    def __init__(self, file: io.FileIO) -> None:
        self._file = file
        self._at = self._size = 0
        self._error: OSError | None = None
        self._kept: list[tuple[int, bytes]] = []  # (position, content) since the error

    def check(self) -> None:
        """Raise the error of the disk if there was one."""
        if self._error is not None:
            raise self._error

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go to a position; it may be beyond the end."""
        self._at = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._size}[whence]
        return self._at

    def truncate(self, size: int | None = None) -> int:
        """Set the size."""
        self._size = self._at if size is None else size
        if self._error is None:
            try:
                self._file.truncate(self._size)
            except OSError as error:
                self._error = error
        return self._size

    def write(self, content: Any) -> int:
        """Write all of `content`."""
        content = bytes(content)
        if self._error is None:
            try:
                self._file.seek(self._at)
                left = content
                while left:
                    left = left[self._file.write(left) :]
            except OSError as error:
                self._error = error
        if self._error is not None:
            self._kept.append((self._at, content))
        self._at += len(content)
        self._size = max(self._size, self._at)
        return len(content)

    def readinto(self, target: Any) -> int:
        """Read written data, and zeros elsewhere."""
        view = memoryview(target).cast("B")
        count = max(0, min(len(view), self._size - self._at))
        self._file.seek(self._at)
        content = bytearray((self._file.read(count) or b"").ljust(count, b"\0"))
        for place, kept in self._kept:
            first, last = max(place, self._at), min(place + len(kept), self._at + count)
            if first < last:
                content[first - self._at : last - self._at] = kept[first - place : last - place]
        view[:count] = content
        self._at += count
        return count
