"""Spectrum of a labelled signal, over all of its samples."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipelines.io.errors import InputError
from pipelines.signals.spectrum import amplitudes

if TYPE_CHECKING:
    import xarray

FEWEST_SAMPLES = 4


def labelled_spectrum(signal: xarray.DataArray) -> xarray.DataArray:
    """One-sided peak amplitudes over `frequency` (Hz) in place of `time`, with a Hann window; unit of the signal.

    Raises
    ------
    InputError : no dimension time, fewer than four samples, or unequal spacing
    """
    import xarray

    if "time" not in signal.dims or "time" not in signal.coords:
        names = ", ".join(map(str, signal.dims)) or "none"
        raise InputError(
            f"spectrum: the signal has no dimension time with values in s (dimensions: {names}). Give one over time."
        )
    time = np.asarray(signal.time.values, float)
    steps = np.diff(time)
    if time.size < FEWEST_SAMPLES or np.ptp(steps) > 1e-6 * steps.mean():
        raise InputError(
            f"spectrum: the signal has {time.size} samples, or their spacing in time differs. Give "
            f"{FEWEST_SAMPLES} or more samples of equal spacing."
        )
    over_time = signal.transpose("time", ...)
    columns = np.asarray(over_time.values, float).reshape(time.size, -1)
    values = amplitudes(columns).reshape(-1, *over_time.shape[1:])
    others = {name: value for name, value in over_time.coords.items() if "time" not in value.dims}
    frequency = np.arange(len(values)) / (steps.mean() * time.size)
    words = {"units": signal.attrs.get("units", ""), "long_name": f"amplitude of {signal.name or 'the signal'}"}
    return xarray.DataArray(
        values,
        dims=("frequency", *over_time.dims[1:]),
        coords={"frequency": ("frequency", frequency, {"units": "Hz"}), **others},
        attrs=words,
    )
