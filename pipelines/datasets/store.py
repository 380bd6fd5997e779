"""Signals of a campaign: a Zarr group with an array (run, ..., time) per signal, one chunk, so one file, per run.

The arrays are made whole at the start and nothing is ever appended, so that any worker writes any run at any time and
the bits do not depend on the order. A chunk is written aside and moved into place; that it is there proves nothing, see
`pipelines.datasets.rows`. Runs that are not there yet read as NaN.

References
----------
Zarr core specification, version 3 (zarr-specs.readthedocs.io): chunk grid, chunk keys, dimension names.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.datasets.signal_layout import RunLayout
from pipelines.io.errors import InputError

if TYPE_CHECKING:
    import zarr

SIGNALS = "signals.zarr"
_PARTIAL = "*.partial"  # what a writer that was killed leaves


def create_store(folder: Path, runs: int, layout: RunLayout, attributes: Mapping[str, Any]) -> None:
    """Make the group and its arrays in `folder`.

    Parameters
    ----------
    folder : of the campaign
    runs : number of runs
    layout : signals of every run
    attributes : of the group; plain values

    Raises
    ------
    OSError : they cannot be written
    """
    import zarr
    from zarr.codecs import BloscCodec

    group = zarr.create_group(folder / SIGNALS, zarr_format=3, attributes=dict(attributes), overwrite=True)
    packed = BloscCodec(cname="lz4", clevel=5, shuffle="shuffle")
    _coordinate(group, "time", np.arange(layout.samples) / layout.rate, {"units": "s"})
    _coordinate(group, "run", np.arange(runs), {"long_name": "number of the scene in the plan"})
    for name, values in layout.names.items():
        text = isinstance(values[0], str)
        _coordinate(group, name, np.array(values, dtype=object if text else np.int64), {})
    for signal in layout.signals:
        group.create_array(
            signal.name,
            shape=(runs, *signal.shape),
            chunks=(1, *signal.shape),
            dtype=signal.dtype,
            compressors=packed,
            fill_value=np.nan,
            attributes=dict(signal.attributes),
            dimension_names=["run", *signal.dims],
            chunk_key_encoding={"name": "default", "separator": "."},  # no folders within folders: a file per run
        )


def _coordinate(group: zarr.Group, name: str, values: np.ndarray, attributes: Mapping[str, str]) -> None:
    kind: Any = str if values.dtype == object else values.dtype
    made = group.create_array(
        name,
        shape=values.shape,
        dtype=kind,
        chunks=values.shape,
        compressors=None,
        attributes=dict(attributes),
        dimension_names=[name],
    )
    made[:] = values


def write_run(folder: Path, run: int, arrays: Mapping[str, np.ndarray]) -> dict[str, str]:
    """Write the signals of a run and wait until the disk has them; SHA-256 of each.

    Parameters
    ----------
    folder : of the campaign
    run : its number
    arrays : signals by name, in the layout of the store

    Raises
    ------
    OSError : they cannot be written
    """
    import zarr

    group = zarr.open_group(folder / SIGNALS, mode="r+", use_consolidated=False)
    found = {}
    for name, values in arrays.items():
        array = group[name]
        assert isinstance(array, zarr.Array)
        array[run] = values
        with open(chunk_path(folder, name, run, values.ndim), "rb") as chunk:
            os.fsync(chunk.fileno())
        found[name] = checksum(values)
    return found


def read_run(folder: Path, run: int, name: str) -> np.ndarray:
    """A signal of a run as it is stored.

    Raises
    ------
    InputError : the store is not there, or its chunk is damaged
    """
    import zarr

    try:
        return np.asarray(zarr.open_array(folder / SIGNALS / name, mode="r")[run])
    except (OSError, ValueError, RuntimeError, KeyError) as error:
        raise InputError(
            f"{folder / SIGNALS}: {name} of run {run} cannot be read ({error}). Delete the row of the run and repeat "
            "the campaign."
        ) from error


def checksum(values: np.ndarray) -> str:
    """SHA-256 of the numbers."""
    return hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()


def sweep(folder: Path) -> None:
    """Remove what writers that were killed left; to be called when nobody writes."""
    for path in (folder / SIGNALS).glob(f"*/{_PARTIAL}"):
        path.unlink(missing_ok=True)


def chunk_path(folder: Path, name: str, run: int, dims: int) -> Path:
    """The file of a signal of a run.

    Parameters
    ----------
    folder, name, run : the campaign, its signal and its run
    dims : dimensions of the signal without that of the runs
    """
    return folder / SIGNALS / name / ".".join(["c", str(run), *["0"] * dims])
