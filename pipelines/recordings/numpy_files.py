"""NumPy files: NPY, read in place, and NPZ, whose arrays are unpacked into memory."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from pipelines.recordings.channels import RecordedChannel, RecordedContents, array_channels, says_rate


def open_npy(path: Path) -> RecordedContents:
    """The channels of an array, mapped from the file: a column each, or a field each."""
    values = np.load(path, mmap_mode="r", allow_pickle=False)
    if values.dtype.names is None:
        return RecordedContents(channels=tuple(array_channels("channel", values)))
    fields = [channel for name in values.dtype.names for channel in array_channels(name, values[name])]
    return RecordedContents(channels=tuple(fields))


def npz_memory(path: Path) -> int:
    """Bytes of all its arrays, unpacked."""
    with zipfile.ZipFile(path) as archive:
        return sum(entry.file_size for entry in archive.infolist())


def open_npz(path: Path) -> RecordedContents:
    """The channels of all its arrays; one number that is called fs, sample_rate or the like is the sampling rate."""
    with np.load(path, allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    return RecordedContents(channels=named_arrays(arrays), texts=texts(arrays))


def texts(arrays: dict[str, np.ndarray]) -> str:
    """The texts among named arrays."""
    return " ".join(str(value) for value in arrays.values() if value.dtype.kind == "U" and value.size == 1)


def named_arrays(arrays: dict[str, np.ndarray]) -> tuple[RecordedChannel, ...]:
    """The channels of named arrays, of which single numbers are settings."""
    rates = [float(value.item()) for name, value in arrays.items() if value.size == 1 and says_rate(name)]
    rate = rates[0] if rates else None
    return tuple(channel for name, value in arrays.items() for channel in array_channels(name, value, rate=rate))
