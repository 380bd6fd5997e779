"""Levels of a run or recording: acceleration and velocity of every channel; loss of contact of the flanks.

Velocity is the root mean square in the band 10 to 1000 Hz, the broad-band measure of ISO 20816-1 for housings. The
acceleration of a window without run-up is integrated in the frequency domain.

References
----------
ISO 20816-1:2016, 4.2 (broad-band velocity, 10 Hz to 1000 Hz).
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipelines.io.text_table import Grid, grid

if TYPE_CHECKING:
    import xarray

BAND = (10.0, 1000.0)  # Hz
OPEN = ":microseconds_open"  # follows the name of a mesh in the name of a counter


@dataclass(frozen=True, kw_only=True)
class ChannelLevel:
    """Root mean square of the acceleration (m/s2) and of the velocity in BAND (m/s) of a channel in a window."""

    sensor: str
    axis: str
    window: str
    acceleration: float
    velocity: float


def band_velocity(acceleration: np.ndarray, rate: float) -> np.ndarray:
    """Root mean square (...,) of the velocity in BAND, m/s, from accelerations (time, ...) in m/s2 at a rate in Hz.

    A Hann window limits leakage into the band; the result is corrected for its mean square, 3/8.
    """
    count = len(acceleration)
    shape = (count,) + (1,) * (acceleration.ndim - 1)
    weights = np.hanning(count + 1)[:-1].reshape(shape)
    spectrum = np.fft.rfft((acceleration - acceleration.mean(axis=0)) * weights, axis=0)
    frequency = np.fft.rfftfreq(count, 1.0 / rate)
    inside = (frequency >= BAND[0]) & (frequency <= BAND[1])
    parts = np.abs(spectrum[inside]) ** 2 / (2 * np.pi * frequency[inside].reshape((-1,) + shape[1:])) ** 2
    return np.sqrt(2.0 * parts.sum(axis=0) / count**2 / 0.375)


def levels(run: xarray.Dataset, windows: Mapping[str, tuple[float, float]]) -> tuple[ChannelLevel, ...]:
    """Levels of all channels with a signal in each window (s); empty without sensors.

    Without windows the second half of the run is evaluated.
    """
    if "acceleration" not in run:
        return ()
    time = run.time.values
    rate = 1.0 / float(time[1] - time[0])
    spans = dict(windows) or {"second half": (float(time[len(time) // 2]), float(time[-1]))}
    found = []
    for name, (start, end) in spans.items():
        part = run.acceleration.sel(time=slice(start, end)).transpose("time", "sensor", "axis")
        if part.sizes["time"] < 16:
            continue
        values = part.values.astype(float)
        both = np.stack([values.std(axis=0), band_velocity(values, rate)], axis=-1)  # NaN for an axis without signal
        found += [
            ChannelLevel(sensor=str(sensor), axis=str(axis), window=name, acceleration=acceleration, velocity=velocity)
            for sensor, rows in zip(part.sensor.values, both.tolist(), strict=True)
            for axis, (acceleration, velocity) in zip(part.axis.values, rows, strict=True)
            if np.isfinite(velocity)
        ]
    return tuple(found)


def level_grid(found: Sequence[ChannelLevel]) -> Grid:
    """Table of the levels: a row for each sensor and window, columns for its axes."""
    rows: dict[tuple[str, str], dict[str, str]] = {}
    for one in found:
        row = rows.setdefault((one.sensor, one.window), {"sensor": one.sensor, "window": one.window})
        row[f"acceleration {one.axis} m/s²"] = f"{one.acceleration:.3g}"
        row[f"velocity {one.axis} mm/s"] = f"{1000 * one.velocity:.3g}"
    return grid("RMS levels; velocity from 10 to 1000 Hz (ISO 20816-1)", rows.values())


def contact_sentence(run: xarray.Dataset) -> str:
    """Sentence on how often the drive flanks lost contact, and for which share of the time; "" if they never did."""
    counters = json.loads(run.attrs.get("counters", "{}"))
    length = float(run.time[-1] - run.time[0]) or 1.0
    found = []
    for name, count in counters.items():
        if name.endswith(":contact_losses") and count:
            mesh = name.partition(":")[0]
            share = counters.get(f"{mesh}{OPEN}", 0) / 1e6 / length
            found.append(f"{mesh.replace('_', ' ')} {count} times ({100 * share:.2g} % of the time)")
    return f"Drive flanks lost contact: {', '.join(found)}." if found else ""
