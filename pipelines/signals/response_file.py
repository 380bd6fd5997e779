"""response.nc: the signals of a motion, written block by block, so that no run is too long for memory.

The signals have the lossless filters shuffle and deflate, which every netCDF-4 reader knows. They are packed here and
not by the HDF5 library, because the strategy "run lengths" of deflate leaves such signals as small as its full search
does in half the time.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from fem.storage.hdf5 import careful_file
from mbd.output.trajectory import Trajectory
from pipelines.signals.labelled import coordinates, facts, read, signals

BLOCK = 8192  # samples written at once, and of one signal packed together
_FILTERS: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}


def write_response(motion: Trajectory, labels: Mapping[str, Any], path: Path | str) -> None:
    """Write what `pipelines.signals.response.make_response` gives as a netCDF-4 file.

    Raises
    ------
    OSError : the file cannot be written
    """
    import h5netcdf
    import h5py

    block = min(BLOCK, len(motion.time))
    wanted = list(signals(motion))
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
            for signal in wanted:
                dims, chunks = ("time", *signal.dims), (block, *(1 for _ in signal.dims))
                made = file.create_variable(signal.name, dims, signal.dtype, chunks=chunks, **_FILTERS)
                made.attrs.update(signal.attributes)
        with h5py.File(disk, "r+") as file:
            chunked = {signal.name: file[signal.name].id for signal in wanted}
            for first in range(0, len(motion.time), block):
                for signal in wanted:
                    samples = read(motion, signal, slice(first, first + block))
                    whole = np.zeros((block, *signal.rows.shape), signal.dtype)
                    whole[: len(samples)] = samples
                    for place in product(*map(range, signal.rows.shape)):
                        one: tuple[Any, ...] = (slice(None), *place)
                        chunked[signal.name].write_direct_chunk((first, *place), _packed(whole[one]))
                disk.check()


def _packed(values: np.ndarray) -> bytes:
    """Values after the filters shuffle (first bytes of all values, then second ones, ...) and deflate."""
    planes = np.ascontiguousarray(values).view(np.uint8).reshape(len(values), -1).T
    deflate = zlib.compressobj(1, zlib.DEFLATED, zlib.MAX_WBITS, 7, zlib.Z_RLE)
    return deflate.compress(planes.tobytes()) + deflate.flush()
