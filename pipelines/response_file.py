"""response.nc: a response written block by block, so that no run is too long for memory."""

from __future__ import annotations

from pathlib import Path

import h5netcdf
import h5py
import xarray

from fem.hdf5 import careful_file

BLOCK = 8192  # samples written at once, and of one signal kept together in the file


def write_response(run: xarray.Dataset, path: Path | str) -> None:
    """Write a netCDF-4 file, signals with the lossless filters shuffle and deflate.

    Raises
    ------
    OSError : the file cannot be written
    """
    with careful_file(path) as disk, h5netcdf.File(disk, "w") as file:
        file.dimensions = {str(name): size for name, size in run.sizes.items()}
        file.attrs.update(run.attrs)
        for name, variable in run.variables.items():
            text = variable.dtype.kind in "OUT"
            over_time = variable.dims[:1] == ("time",)
            stored = file.create_variable(
                str(name),
                tuple(map(str, variable.dims)),
                h5py.string_dtype() if text else variable.dtype,
                chunks=(min(BLOCK, run.sizes["time"]), *(1 for _ in variable.dims[1:])) if over_time else None,
                **({"compression": "gzip", "compression_opts": 1, "shuffle": True} if over_time else {}),
            )
            stored.attrs.update(variable.attrs)
            if not over_time:
                stored[...] = variable.values.astype(object if text else variable.dtype)
        for first in range(0, run.sizes["time"], BLOCK):
            block = run.isel(time=slice(first, first + BLOCK))
            for name, variable in block.variables.items():
                if variable.dims[:1] == ("time",):
                    file.variables[str(name)][first : first + BLOCK] = variable.values
            disk.check()
