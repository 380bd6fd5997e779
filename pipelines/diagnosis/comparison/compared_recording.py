"""Recordings prepared for a comparison: their windows, and their common channels and sampling rate."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fem.numerics.sinc_interpolation import interpolated
from pipelines.diagnosis.simulated_features import with_stated_noise
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.signals.features.recording_features import FeatureError, recorded_channels
from pipelines.signals.motion_warnings import stored_warnings
from pipelines.signals.orders.kinematics import Kinematics
from pipelines.signals.orders.rotation import Rotation
from pipelines.signals.orders.rotation_of import rotation_of

if TYPE_CHECKING:
    import xarray

SAME_RATE = 1e-6  # relative difference of equal sampling rates; it covers rounding only, clocks differ by more

Channel = tuple[str, str]  # sensor and axis


@dataclass(frozen=True, eq=False, kw_only=True)
class Window:
    """A window of a recording: `start` and `end` (s) within it, turns of the first shaft, its mean frequency (Hz)."""

    name: str
    start: float
    end: float
    turns: float
    frequency: float


@dataclass(frozen=True, eq=False, kw_only=True)
class ComparedRecording:
    """A recording whose windows are compared.

    `acceleration` (channel, time) in m/s2 holds `channels` at equidistant `time` (s). `warnings` are those of the file.
    """

    name: str
    kinematics: Kinematics
    rotation: Rotation
    windows: tuple[Window, ...]
    channels: tuple[Channel, ...]
    time: np.ndarray
    acceleration: np.ndarray
    warnings: tuple[str, ...]

    @property
    def rate(self) -> float:
        """Samples per second."""
        return (len(self.time) - 1) / float(self.time[-1] - self.time[0])

    @property
    def spans(self) -> dict[str, tuple[float, float]]:
        """Start and end (s) of the windows by name."""
        return {window.name: (window.start, window.end) for window in self.windows}

    def dataset(self) -> xarray.Dataset:
        """The recording as (sensor, axis, time), from which features are computed; NaN for an axis without signal."""
        import xarray

        sensors, axes = (list(dict.fromkeys(names)) for names in zip(*self.channels, strict=True))
        laid = np.full((len(sensors), len(axes), len(self.time)), np.nan)
        for (sensor, axis), signal in zip(self.channels, self.acceleration, strict=True):
            laid[sensors.index(sensor), axes.index(axis)] = signal
        return xarray.Dataset(
            {"acceleration": (("sensor", "axis", "time"), laid)},
            coords={"sensor": sensors, "axis": axes, "time": self.time},
        )


def compared_recording(
    name: str,
    recording: xarray.Dataset,
    kinematics: Kinematics,
    windows: Mapping[str, tuple[float, float]] | None = None,
) -> ComparedRecording:
    """The channels of a recording that hold a signal, with its rotation.

    Parameters
    ----------
    name : as results show it
    recording : simulated or measured
    kinematics : of its machine
    windows : name -> start and end (s) of each compared window; the whole recording if None

    Raises
    ------
    FeatureError : no accelerations, no channel with a signal, or a window outside the recording
    RotationError : see `pipelines.signals.orders.rotation_of`
    """
    sensors, axes, values = recorded_channels(with_stated_noise(recording))
    rotation = rotation_of(recording, kinematics)
    time = np.asarray(recording.time.values, dtype=float)
    whole = {"whole": (float(time[0]), float(time[-1]))}
    return ComparedRecording(
        name=name,
        kinematics=kinematics,
        rotation=rotation,
        windows=tuple(_window(one, span, time, rotation) for one, span in (windows or whole).items()),
        channels=tuple(zip(sensors, axes, strict=True)),
        time=time,
        acceleration=values,
        warnings=tuple(stored_warnings(recording.attrs).values()),
    )


def _window(name: str, span: tuple[float, float], time: np.ndarray, rotation: Rotation) -> Window:
    """The part of a window that is within the recording, with its turns and mean rotation frequency."""
    first, last = np.searchsorted(time, span[0]), np.searchsorted(time, span[1], side="right") - 1
    if not last > first:
        raise FeatureError(
            f"window {span[0]:g} to {span[1]:g} s: the recording lasts from {time[0]:g} to {time[-1]:g} s. Choose a "
            "window within it, its start before its end."
        )
    turns = abs(float(rotation.angle[last] - rotation.angle[first])) / (2.0 * math.pi)
    start, end = float(time[first]), float(time[last])
    return Window(name=name, start=start, end=end, turns=turns, frequency=turns / (end - start))


def chosen_channel(part: ComparedRecording, sensor: str | None, axis: str | None) -> Channel:
    """The channel with the highest rms among those of a sensor and an axis; None allows every sensor or axis.

    Raises
    ------
    InputError : no such channel
    """
    levels = dict(zip(part.channels, part.acceleration.std(axis=-1), strict=True))
    fitting = [one for one in part.channels if sensor in (None, one[0]) and axis in (None, one[1])]
    if not fitting:
        there = ", ".join(" ".join(map(shown, channel)) for channel in part.channels)
        requested = " ".join(shown(one) for one in (sensor, axis) if one is not None)
        raise InputError(f"{requested}: not a channel of all recordings. Set --sensor and --axis to one of {there}.")
    return max(fitting, key=lambda channel: float(levels[channel]))


def brought_together(parts: Sequence[ComparedRecording]) -> tuple[ComparedRecording, ...]:
    """The parts with the channels that all of them have, resampled to the lowest of their rates.

    Raises
    ------
    FeatureError : they have no channel in common
    """
    common = [channel for channel in parts[0].channels if all(channel in part.channels for part in parts)]
    if not common:
        sensors = "; ".join(f"{part.name}: {', '.join(' '.join(one) for one in part.channels[:9])}" for part in parts)
        raise FeatureError(
            f"no channel is in all recordings ({sensors}). Set the same sensor names in the machine file."
        )
    lowest = min(part.rate for part in parts)
    rows = [[part.channels.index(channel) for channel in common] for part in parts]
    return tuple(
        _at_rate(replace(part, channels=tuple(common), acceleration=part.acceleration[own]), lowest)
        for part, own in zip(parts, rows, strict=True)
    )


def _at_rate(part: ComparedRecording, rate: float) -> ComparedRecording:
    """The part resampled to `rate` (Hz) if that is lower; frequencies below 0.45 of it pass, above 0.55 they do not."""
    if part.rate <= rate * (1.0 + SAME_RATE):
        return part
    count = int((part.time[-1] - part.time[0]) * rate * (1.0 + SAME_RATE)) + 1
    position = np.minimum(np.arange(count) * part.rate / rate, len(part.time) - 1)
    angle = np.interp(position, np.arange(len(part.time)), part.rotation.angle)
    return replace(
        part,
        time=part.time[0] + np.arange(count) / rate,
        rotation=replace(part.rotation, angle=angle),
        acceleration=interpolated(part.acceleration, position, rate / part.rate),
    )
