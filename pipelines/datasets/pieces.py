"""Pieces: windows of the stored accelerations with added sensor noise; nothing is simulated or stored.

As in a recording, noise is generated for the whole run, and pieces are cut from the noisy signal. The noise depends
only on seed, run, sensor and axis, so that a piece does not depend on the selection or the order of the others.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipelines.datasets.dataset_reading import vibration
from pipelines.datasets.rows import DONE
from pipelines.io.errors import InputError
from pipelines.signals.analysis import sampling
from pipelines.signals.spectrum import with_noise

if TYPE_CHECKING:
    import xarray


def pieces(
    dataset: xarray.Dataset,
    seconds: float | None = None,
    overlap: float = 0.0,
    noise_m_s2: float = 0.0,
    seed: int = 0,
    sensors: Sequence[str] | None = None,
) -> Iterator[xarray.DataArray]:
    """Windows of the accelerations of each finished run, one run at a time in the order of the data set.

    Parameters
    ----------
    dataset : result of `open_dataset`, or a part of it: some runs, or an interval of time
    seconds : length of a piece; the whole run if None
    overlap : share of a piece that the next one repeats, from 0 to below 1
    noise_m_s2 : rms of the white sensor noise
    seed : of the noise
    sensors : names; all if None

    Returns
    -------
    for each run float32 (piece, sensor, axis, time); `time` is measured from the start of the piece. Coordinates along
    `piece` are `start` (s), `run` and all columns of its row. An array holds pieces of one run only

    Raises
    ------
    InputError : a sensor is not in the data set, or length, overlap or noise is out of range
    DiagnosisError : the times of the samples are not equidistant
    """
    signal = vibration(dataset)
    if sensors is not None:
        known = [str(name) for name in signal.sensor.values]
        for name in sensors:
            if name not in known:
                raise InputError(f"sensors: {name!r} is not in this data set. Allowed: {', '.join(known)}.")
        signal = signal.sel(sensor=list(sensors))
    rate, begin = sampling(dataset)
    length = dataset.sizes["time"]
    size = length if seconds is None else round(seconds * rate)
    if not 1 <= size <= length:
        part = f" from {begin:g} s on" if begin else ""
        raise InputError(
            f"seconds = {seconds:g}: the runs last {length / rate:g} s{part}. Set a value above 0 and up to that."
        )
    if not 0.0 <= overlap < 1.0:
        raise InputError(f"overlap = {overlap:g}: set a share from 0 to below 1.")
    if noise_m_s2 < 0.0 or seed < 0:
        raise InputError(f"noise of {noise_m_s2:g} m/s2 with seed {seed}: set both to 0 or more.")
    step = max(1, round(size * (1.0 - overlap)))
    return _pieces(dataset, signal, rate, round(begin * rate), size, step, noise_m_s2, seed)


def _pieces(
    dataset: xarray.Dataset,
    signal: xarray.DataArray,
    rate: float,
    first: int,
    size: int,
    step: int,
    noise: float,
    seed: int,
) -> Iterator[xarray.DataArray]:
    import xarray

    for place in np.flatnonzero(dataset.status.values == DONE):
        one = signal.isel(run=place).transpose("sensor", "axis", "time")
        sensors, axes = map(str, one.sensor.values), map(str, one.axis.values)
        noisy = noisy_run(one.values, int(one.run), list(sensors), list(axes), noise, seed, first)
        windows = np.lib.stride_tricks.sliding_window_view(noisy, size, axis=-1)[:, :, ::step]
        starts = (first + np.arange(windows.shape[2]) * step) / rate
        columns = {
            name: ("piece", np.full(len(starts), column.values[place]))
            for name, column in dataset.coords.items()
            if column.dims == ("run",)
        }
        yield xarray.DataArray(
            np.moveaxis(windows, 2, 0),
            dims=("piece", "sensor", "axis", "time"),
            coords={
                **columns,
                "start": ("piece", starts, {"units": "s"}),
                "sensor": one.sensor.values,
                "axis": one.axis.values,
                "time": ("time", np.arange(size) / rate, {"units": "s"}),
            },
            name="acceleration",
            attrs={"units": signal.attrs.get("units", "m/s2"), "sensor_noise_m_s2": noise},
        )


def noisy_run(
    values: np.ndarray, run: int, sensors: Sequence[str], axes: Sequence[str], noise: float, seed: int, first: int = 0
) -> np.ndarray:
    """The accelerations of a run with white sensor noise, as float32.

    Parameters
    ----------
    values : (sensor, axis, time), m/s2
    run : number of the run
    sensors, axes : names
    noise : rms, m/s2
    seed : of the noise
    first : number of the first sample, counted from the start of the run
    """
    values = np.asarray(values, dtype=np.float32)
    if noise == 0.0:
        return values
    noisy = np.empty_like(values)
    for i, sensor in enumerate(sensors):
        for j, axis in enumerate(axes):
            fixed = [seed, run, zlib.crc32(sensor.encode()), zlib.crc32(axis.encode())]
            whole = with_noise(np.zeros(first + values.shape[-1]), noise, fixed)
            noisy[i, j] = values[i, j] + whole[first:]
    return noisy
