"""NumPy files: NPY, read in place, and NPZ, whose arrays are unpacked into memory."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from pipelines.recordings.recording_channels import RecordedChannel, RecordedContents, array_channels, says_rate


def memory(path: Path) -> int:
    """Bytes of all arrays of an NPZ file, unpacked."""
    with zipfile.ZipFile(path) as archive:
        return sum(entry.file_size for entry in archive.infolist())


def open_channels(path: Path) -> RecordedContents:
    """The channels of an array, which is mapped from the file, or of its fields; those of all arrays of an NPZ file.

    One number that is called fs, sample_rate or the like is the sampling rate.
    """
    content = np.load(path, mmap_mode="r", allow_pickle=False)
    if isinstance(content, np.ndarray):
        fields = content.dtype.names
        arrays = {"channel": content} if fields is None else {name: content[name] for name in fields}
    else:
        with content:
            arrays = {name: content[name] for name in content.files}
    return RecordedContents(channels=named_arrays(arrays), texts=texts(arrays))


def texts(arrays: dict[str, np.ndarray]) -> str:
    """The texts among named arrays."""
    return " ".join(str(value) for value in arrays.values() if value.dtype.kind == "U" and value.size == 1)


def named_arrays(arrays: dict[str, np.ndarray]) -> tuple[RecordedChannel, ...]:
    """The channels of named arrays, of which single numbers are settings."""
    rates = (float(value.item()) for name, value in arrays.items() if value.size == 1 and says_rate(name))
    rate = next(rates, None)
    return tuple(channel for name, value in arrays.items() for channel in array_channels(name, value, rate=rate))
