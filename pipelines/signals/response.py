"""Response of a run: the signals of a motion as a labelled dataset, as in response.nc.

The dataset is a view of the motion. A signal is read, and rounded as in response.nc, when it is used. Results from the
motion and from the file are therefore equal to the last digit.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray
from xarray.core import indexing

from mbd.output.trajectory import Trajectory
from pipelines.signals.labelled_signals import LabelledSignal, coordinates, facts, read, signals
from pipelines.signals.lazy_array import LazyArray, Place


def make_response(motion: Trajectory, labels: Mapping[str, Any]) -> xarray.Dataset:
    """The dataset: named dimensions, units on every variable, `labels` and facts as attributes."""
    data = {
        signal.name: xarray.Variable(
            ("time", *signal.dims), indexing.LazilyIndexedArray(_array(motion, signal)), signal.attributes
        )
        for signal in signals(motion)
    }
    time = {"time": ("time", motion.time, {"units": "s"})}
    return xarray.Dataset(data, coords=time | coordinates(motion), attrs={**labels, **facts(motion)})


def _array(motion: Trajectory, signal: LabelledSignal) -> LazyArray:
    shape = (motion.values.shape[1], *signal.rows.shape)
    return LazyArray(shape, signal.dtype, partial(_part, motion, signal))


def _part(motion: Trajectory, signal: LabelledSignal, place: Place) -> np.ndarray:
    return read(motion, signal, place[0], place[1:])
