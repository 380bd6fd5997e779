"""Features of a simulated run, with the sensor noise that it states."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipelines.signals.analysis import channel_names, noisy_channel
from pipelines.signals.features.feature_table import FeatureTable
from pipelines.signals.features.recording_features import FeatureError, recording_features
from pipelines.signals.orders.kinematics import Kinematics
from pipelines.signals.orders.rotation import Rotation
from pipelines.signals.orders.rotation_of import rotation_of

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, kw_only=True)
class FeatureSettings:
    """Kinematics of the machine and diagnosed windows (s) by name; the whole run if there are none.

    `complete` selects all features instead of those that are evidence in a diagnosis.
    """

    kinematics: Kinematics
    windows: Mapping[str, tuple[float, float]]
    complete: bool = False


def run_features(run: xarray.Dataset, settings: FeatureSettings, rotation: Rotation | None = None) -> FeatureTable:
    """The features of a run or of any other recording.

    Parameters
    ----------
    run : response of a simulation, or a recording; noise of the RMS in its attribute `sensor_noise_m_s2` is added
    settings : machine and windows
    rotation : of the first shaft; if None it is determined from the recording

    Raises
    ------
    FeatureError : see `recording_features`
    RotationError : see `pipelines.signals.orders.rotation_of`
    """
    noisy = with_stated_noise(run)
    if rotation is None:
        rotation = rotation_of(run, settings.kinematics)
    return recording_features(noisy, settings.kinematics, rotation, settings.windows, settings.complete)


def window_features(run: xarray.Dataset, settings: FeatureSettings, samples: int = 1) -> dict[str, list[FeatureTable]]:
    """Features of a run by window, a list of one table for each of `samples` samples of its sensor noise.

    Other arguments and errors are as for `run_features`.
    """
    noisy = [with_stated_noise(run, sample) for sample in range(samples)]
    rotation = rotation_of(run, settings.kinematics)
    return {
        name: [recording_features(one, settings.kinematics, rotation, {name: window}) for one in noisy]
        for name, window in settings.windows.items()
    }


def with_stated_noise(run: xarray.Dataset, sample: int = 0) -> xarray.Dataset:
    """A run whose accelerations contain noise of the RMS in its attribute `sensor_noise_m_s2`, if it has one.

    The seed of the noise follows from the signals and the number of the sample. The noise of a run is therefore
    repeatable, and differs from that of any other run.

    Raises
    ------
    FeatureError : there are no accelerations
    """
    name = "acceleration" if "acceleration" in run else "journal_acceleration"
    if name not in run:
        raise FeatureError("the recording holds no accelerations. Add sensors to the scene, or give another recording")
    stored = run[name].transpose("time", ...).values.astype(np.float32)  # as in every file of the same signals
    stream = zlib.crc32(stored.tobytes()) + sample
    axes = [str(axis) for axis in run.axis.values]
    signal = np.stack([noisy_channel(run, sensor, axes, stream).T for sensor in channel_names(run)])
    return run.drop_vars(name).assign({name: ((*run[name].transpose(..., "time").dims[:-1], "time"), signal)})
