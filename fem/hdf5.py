"""HDF5 files that are made in memory and written in one go.

A disk that fills up while the HDF5 library writes leaves it with objects it cannot close, which may end the process.
Written afterwards, the same disk is an OSError like any other.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import h5py


@contextlib.contextmanager
def hdf5_file(path: Path | str, start: bytes = b"") -> Iterator[h5py.File]:
    """An open HDF5 file, empty or with the content `start`; it is written to `path` when the block ends well.

    Raises
    ------
    OSError : the file cannot be written
    """
    import h5py

    memory = io.BytesIO(start)
    with h5py.File(memory, "a" if start else "w") as file:
        yield file
    Path(path).write_bytes(memory.getbuffer())
