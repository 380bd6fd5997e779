"""response.nc: the signals of a motion, written and read block by block to limit memory.

The last 48 bytes are a checksum of all bytes before them, since HDF5 does not check all of them. Readers of netCDF
ignore bytes after the end of the HDF5 data. A program that changes the file removes the checksum.

The signals have the lossless filters shuffle and deflate, which every netCDF-4 reader supports.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from fem.storage.hdf5_file import CarefulFile, blocks_missing, careful_file
from mbd.output.trajectory import Trajectory
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.io.user_files import regular_file
from pipelines.signals.labelled_signals import coordinates, facts, read, signals

if TYPE_CHECKING:
    import xarray

BLOCK = 8192  # samples that are written at once, and samples of a signal in one chunk
_FILTERS: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
_MARK = b"gearcase sha256:"  # before the checksum
_CHECKSUM_BYTES = len(_MARK) + hashlib.sha256().digest_size


def write_response(motion: Trajectory, labels: Mapping[str, Any], path: Path | str) -> None:
    """Write a response of `pipelines.signals.response.make_response` as a netCDF-4 file.

    Raises
    ------
    OSError : the file cannot be written
    """
    import h5netcdf
    import h5py

    block = min(BLOCK, len(motion.time))
    everything = list(signals(motion))
    with careful_file(path) as disk:
        with h5netcdf.File(disk, "w") as file:
            file.attrs.update({**labels, **facts(motion)})
            named = coordinates(motion)
            file.dimensions = {"time": len(motion.time)} | {name: len(values) for name, values in named.items()}
            time = file.create_variable("time", ("time",), "<f8", data=motion.time, chunks=(block,), **_FILTERS)
            time.attrs["units"] = "s"
            for name, values in named.items():
                stored, kind = (h5py.string_dtype(), object) if isinstance(values[0], str) else (np.dtype("<i8"), int)
                file.create_variable(name, (name,), stored)[...] = np.array(values, dtype=kind)
            variables = {}
            for signal in everything:
                dims, chunks = ("time", *signal.dims), (block, *(1 for _ in signal.dims))
                made = file.create_variable(signal.name, dims, signal.dtype, chunks=chunks, **_FILTERS)
                made.attrs.update(signal.attributes)
                variables[signal.name] = made
            for first in range(0, len(motion.time), block):
                part = slice(first, min(first + block, len(motion.time)))
                for signal in everything:
                    variables[signal.name][part] = read(motion, signal, part)
                disk.check()
        size = disk.seek(0, os.SEEK_END)
        disk.write(_MARK + _digest(disk, size))


def open_response(path: Path) -> xarray.Dataset:
    """The signals in response.nc or a file of its form, each read when it is used; close it, or use it in `with`.

    The checksum is verified. A file without a checksum is read completely, which detects damage at once.

    Raises
    ------
    FileNotFoundError : there is no such file
    InputError : it is damaged, or holds no signals
    """
    import h5py
    import xarray

    regular_file(path)
    verified = has_checksum(path)
    if verified:
        with path.open("rb") as file:
            size = path.stat().st_size - _CHECKSUM_BYTES
            digest = _digest(file, size)
            if file.read(_CHECKSUM_BYTES) != _MARK + digest:
                raise _damaged(path, "its content does not match its checksum")
    try:
        if not verified:
            with h5py.File(path, "r") as file:
                _read_once("/", file)
                file.visititems(_read_once)
        return xarray.open_dataset(path, engine="h5netcdf")
    except Exception as error:  # the libraries raise errors of every kind
        raise _damaged(path, " ".join(str(error).split()) or type(error).__name__) from error


def has_checksum(path: Path) -> bool:
    """Whether a file ends with a checksum of `write_response`."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - _CHECKSUM_BYTES))
        return file.read(len(_MARK)) == _MARK


def _digest(file: BinaryIO | CarefulFile, size: int) -> bytes:
    """SHA-256 of the first `size` bytes of a file; the file position is then after them."""
    file.seek(0)
    total = hashlib.sha256()
    for first in range(0, size, 1 << 20):
        total.update(file.read(min(1 << 20, size - first)) or b"")
    return total.digest()


def _read_once(name: str, item: Any) -> None:
    """Read the attributes and samples of a group or dataset of HDF5, block by block; damage raises an error."""
    dict(item.attrs)
    if getattr(item, "shape", ()):
        if problem := blocks_missing(item):
            raise OSError(f"{name} {problem}")
        for first in range(0, len(item), BLOCK):
            item[first : first + BLOCK]


def _damaged(path: Path, reason: str) -> InputError:
    return InputError(
        f"{shown(path)}: cannot be read as signals ({shown(reason)}). The file is damaged or cut off; copy it again, "
        "or run the scene again."
    )
