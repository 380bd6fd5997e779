"""HDF5 files, netCDF-4 among them: every dataset of one or two dimensions, read part by part from the file."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fem.storage.hdf5_file import blocks_missing
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.recordings.recording_channels import RecordedChannel, RecordedContents, array_channels, says_rate

_REFERENCES = "#refs#"  # where MATLAB keeps what its cells hold
_TEXT_CLASSES = ("char", "logical")  # of MATLAB, stored as numbers


def open_channels(path: Path) -> RecordedContents:
    """The channels of all datasets, named by their paths.

    Attributes `units` and `fs`, `sample_rate` or the like of a dataset are obeyed, as is a dataset or an attribute of
    the file that holds the rate.

    Raises
    ------
    InputError : a classic netCDF file
    """
    import h5py

    with path.open("rb") as start:
        if start.read(3) == b"CDF":
            raise InputError(
                f"{shown(path)}: is a classic netCDF file, only netCDF-4 is read. Convert it with: nccopy -k nc4."
            )
    with contextlib.ExitStack() as opened:
        file = opened.enter_context(h5py.File(path, "r"))
        channels, texts = tuple(_channels(file)), " ".join(_text(value) for value in file.attrs.values())
        return RecordedContents(channels=channels, close=opened.pop_all().close, texts=texts)


def holds_recording(path: Path) -> bool:
    """Whether a file holds acceleration(time, sensor, axis), as the response of a run does."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            found = file.get("acceleration")
            return isinstance(found, h5py.Dataset) and found.ndim == 3 and {"time", "sensor", "axis"} <= file.keys()
    except Exception:  # damaged, or no HDF5: who reads it refuses it
        return False


def _channels(file: Any) -> Iterator[RecordedChannel]:
    import h5py

    datasets: dict[str, Any] = {}

    def take(name: str, item: Any) -> None:
        hidden = name.startswith(_REFERENCES) or _text(item.attrs.get("MATLAB_class", "")) in _TEXT_CLASSES
        if isinstance(item, h5py.Dataset) and not hidden:
            datasets[name.replace("/", ".")] = item

    file.visititems(take)
    settings = {name: item[()] for name, item in datasets.items() if item.size == 1 and item.dtype.kind in "iuf"}
    common = _rate(settings) or _rate(file.attrs)
    for name, item in datasets.items():
        rate, units = _rate(item.attrs) or common, _text(item.attrs.get("units", ""))
        yield from array_channels(name, item, units=units, rate=rate, problem=blocks_missing(item))


def _rate(attributes: Mapping[str, Any]) -> float | None:
    """The sampling rate (Hz) among single numbers, such as the attributes of a dataset or file."""
    return next((float(np.ravel(value)[0]) for name, value in attributes.items() if says_rate(name)), None)


def _text(value: Any) -> str:
    return value.decode("utf-8", errors="replace") if isinstance(value, bytes) else str(value)
