"""Arrays too large for memory, in a .npy file that is written by blocks of columns and read by parts.

The file is a plain .npy in row order, so that a row is contiguous and `numpy.load` opens it. It is not compressed:
shuffle and deflate reduce float64 signals by a tenth only and take more time than the disk.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np


class StoredArray:
    """A float64 array (row, column) in a .npy file; an index reads that part and returns it as an array.

    ``StoredArray(path)`` opens a file, `create` makes one. The object keeps no data in memory and no open file.
    """

    ndim = 2
    dtype = np.dtype("<f8")

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        part = np.load(self.path, mmap_mode="r", allow_pickle=False)
        if part.ndim != self.ndim or part.dtype != self.dtype or not part.flags.c_contiguous:
            raise ValueError(f"{path}: holds {part.dtype} of shape {part.shape}, expected a table of float64")
        self.shape: tuple[int, int] = part.shape
        self._start = part.offset

    @classmethod
    def create(cls, path: Path | str, shape: tuple[int, int]) -> StoredArray:
        """A new file of zeros, to be filled by ``array[:, first:last] = block``.

        Raises
        ------
        OSError : the file cannot be written
        """
        with open(path, "wb") as file:
            header = {"descr": cls.dtype.str, "fortran_order": False, "shape": shape}
            np.lib.format.write_array_header_1_0(file, header)
            file.truncate(file.tell() + shape[0] * shape[1] * cls.dtype.itemsize)
        return cls(path)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, key: Any) -> Any:
        return np.array(self._map()[key])[()]

    def __setitem__(self, key: tuple[slice, slice], block: np.ndarray) -> None:
        """Write a block (row, column) of all rows, without memory mapping: a full disk raises OSError."""
        rows, columns = key
        if rows != slice(None) or columns.step is not None or block.shape != (len(self), columns.stop - columns.start):
            raise IndexError(f"a block of shape {block.shape} does not fill {key} of {self.shape}")
        with open(self.path, "r+b") as file:
            for number, row in enumerate(np.asarray(block, dtype=self.dtype)):
                file.seek(self._start + (number * self.shape[1] + columns.start) * self.dtype.itemsize)
                file.write(row.tobytes())

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self._map(), dtype=dtype)

    def _map(self) -> np.memmap:
        """The memory-mapped file, for one reading: pages that remain mapped would count as memory of this process."""
        return np.memmap(self.path, self.dtype, "r", self._start, self.shape)
