"""Data sets of campaigns, and pieces of their signals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gearcase.argument_checks import checked_file, checked_recording
from pipelines.datasets import pieces as _views
from pipelines.datasets import reading as _reading

if TYPE_CHECKING:
    import xarray

_DATASET = "Give what gearcase.open_dataset returned."
__all__ = ["open_dataset", "pieces"]


def open_dataset(folder: str | Path) -> xarray.Dataset:
    """Open the signals of a data set of `gearcase campaign`, finished or not; they are read from the disk when used.

    Parameters
    ----------
    folder : folder of the data set

    Returns
    -------
    signals over `run` and time, float32 or float64, with every variable of the plan and every label as a coordinate
    along `run`. A run that is not computed yet has the status "" and the values NaN

    Raises
    ------
    InputError : the folder contains no data set, or a damaged one

    >>> import gearcase
    >>> gearcase.open_dataset("nowhere")
    Traceback (most recent call last):
    ...
    pipelines.io.errors.InputError: nowhere: ...
    """
    return _reading.open_dataset(checked_file("folder", folder, "the folder of a data set"))


def pieces(
    dataset: xarray.Dataset,
    seconds: float | None = None,
    overlap: float = 0.0,
    noise_m_s2: float = 0.0,
    seed: int = 0,
    sensors: Sequence[str] | None = None,
) -> Iterator[xarray.DataArray]:
    """Cut the accelerations into pieces with sensor noise, run by run, so that data sets may exceed the memory.

    Parameters
    ----------
    dataset : result of `open_dataset`, or a part of it, such as ``dataset.isel(run=dataset.split == "train")``
    seconds : length of a piece; None: the whole run
    overlap : share of a piece that the next one repeats, from 0 to below 1
    noise_m_s2 : RMS of added white noise; it does not depend on length, overlap and selected sensors
    seed : seed of the noise
    sensors : names; None: all

    Returns
    -------
    for each finished run, float32 (piece, sensor, axis, time) in m/s2 with `start` (s), `run`, `label`, `split` and all
    other columns along `piece`; runs are never mixed

    Raises
    ------
    InputError : an unknown sensor, or an impossible length, overlap or noise

    >>> import gearcase, numpy, xarray
    >>> signal = numpy.zeros((2, 1, 3, 1000), dtype="float32")
    >>> names = {"run": [0, 1], "sensor": ["s"], "axis": ["x", "y", "z"], "time": numpy.arange(1000) / 1000}
    >>> rows = {"status": ("run", ["done", "done"]), "split": ("run", ["train", "test"])}
    >>> dataset = xarray.Dataset({"acceleration": (tuple(names), signal)}, coords=names | rows)
    >>> for found in gearcase.pieces(dataset, 0.25, noise_m_s2=0.01):
    ...     print(found.shape, str(found.split.values[0]), f"{float(found.std()):.2f} m/s2")
    (4, 1, 3, 250) train 0.01 m/s2
    (4, 1, 3, 250) test 0.01 m/s2
    """
    return _views.pieces(checked_recording("dataset", dataset, _DATASET), seconds, overlap, noise_m_s2, seed, sensors)
