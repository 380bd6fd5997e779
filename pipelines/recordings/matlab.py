"""MATLAB files: version 5 (and 4), read into memory, and version 7.3, which is HDF5."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipelines.recordings import hdf5
from pipelines.recordings.channels import RecordedChannel, RecordedContents, of_array
from pipelines.recordings.numpy_files import named_arrays, texts

_WIDTH = 8  # bytes of a number
_PACKED = 2  # a file with compressed structures takes at least this many times its size


def memory(path: Path) -> int:
    """Bytes that the variables take; 0 for version 7.3, which is read part by part."""
    import h5py

    if h5py.is_hdf5(path):
        return 0
    from scipy.io import whosmat

    plain = sum(_WIDTH * int(np.prod(shape)) for _, shape, _ in whosmat(path))
    return max(plain, _PACKED * path.stat().st_size)


def open_channels(path: Path) -> RecordedContents:
    """The channels of all numeric variables; those of structures are named "structure.field"."""
    import h5py

    if h5py.is_hdf5(path):
        return hdf5.open_channels(path)
    from scipy.io import loadmat

    content = {name: value for name, value in loadmat(path, simplify_cells=True).items() if not name.startswith("__")}
    arrays = dict(_arrays(content))
    return RecordedContents(channels=(*_exported(content), *named_arrays(arrays)), texts=texts(arrays))


def _arrays(content: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, np.ndarray]]:
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _arrays(value, f"{above}{name}.")
        else:
            yield f"{above}{name}", np.asarray(value)


def _exported(content: Mapping[str, Any]) -> Iterator[RecordedChannel]:
    """The accelerations (time, sensor, axis) of a run that `gearcase export` wrote."""
    values, names = np.asarray(content.get("acceleration", 0.0)), content.get("coordinates")
    if values.ndim != 3 or not isinstance(names, Mapping):
        return
    for row, sensor in enumerate(np.atleast_1d(names["sensor"])):
        for column, axis in enumerate(np.atleast_1d(names["axis"])):
            name, place = f"acceleration {sensor} {axis}", (str(sensor), str(axis))
            yield of_array(name, values[:, row, column], units="m/s2", place=place)
