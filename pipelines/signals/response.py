"""Response of a run: the signals of a motion as a labelled dataset, as in response.nc.

The dataset is a view of the motion. A signal is read, and rounded as in response.nc, when it is used. Results from the
motion and from the file are therefore equal to the last digit.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray
from xarray.backends import BackendArray
from xarray.core import indexing

from mbd.output.trajectory import Trajectory
from pipelines.signals.labelled_signals import LabelledSignal, coordinates, facts, read, signals


def make_response(motion: Trajectory, labels: Mapping[str, Any]) -> xarray.Dataset:
    """The dataset: named dimensions, units on every variable, `labels` and facts as attributes."""
    data = {
        signal.name: xarray.Variable(
            ("time", *signal.dims), indexing.LazilyIndexedArray(_View(motion, signal)), signal.attributes
        )
        for signal in signals(motion)
    }
    time = {"time": ("time", motion.time, {"units": "s"})}
    return xarray.Dataset(data, coords=time | coordinates(motion), attrs={**labels, **facts(motion)})


class _View(BackendArray):
    """A signal as an array (time, ...) that is read when it is used."""

    def __init__(self, motion: Trajectory, signal: LabelledSignal) -> None:
        self._motion, self._signal = motion, signal
        self.shape, self.dtype = (motion.values.shape[1], *signal.rows.shape), signal.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> np.ndarray:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._read)

    def _read(self, key: tuple[int | slice, ...]) -> np.ndarray:
        return read(self._motion, self._signal, key[0], key[1:])
