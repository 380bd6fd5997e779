"""Levels of a run: acceleration and velocity at every sensor, and the loss of contact of the flanks.

Velocity is the root mean square in the band 10 to 1000 Hz, the broad-band measure of ISO 20816-1 for housings. The
acceleration of a window without run-up is integrated in the frequency domain.

References
----------
ISO 20816-1:2016, 4.2 (broad-band velocity, 10 Hz to 1000 Hz).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pipelines.io.grid import Grid, grid

if TYPE_CHECKING:
    import xarray

BAND = (10.0, 1000.0)  # Hz
OPEN = ":microseconds_open"  # follows the name of a mesh in the name of a counter


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


def level_grid(run: xarray.Dataset, windows: Mapping[str, tuple[float, float]]) -> Grid | None:
    """Table of the levels of each sensor and window: largest axis and resultant; None without sensors.

    Without windows the second half of the run is evaluated.
    """
    if "acceleration" not in run:
        return None
    time = run.time.values
    rate = 1.0 / float(time[1] - time[0])
    spans = dict(windows) or {"second half": (float(time[len(time) // 2]), float(time[-1]))}
    rows = []
    for name, (start, end) in spans.items():
        part = run.acceleration.sel(time=slice(start, end)).transpose("time", "sensor", "axis")
        if part.sizes["time"] < 16:
            continue
        values = part.values.astype(float)
        velocity, acceleration = 1000 * band_velocity(values, rate), values.std(axis=0)
        for i, sensor in enumerate(part.sensor.values):
            top = int(velocity[i].argmax())
            rows.append(
                {
                    "sensor": sensor,
                    "window": name,
                    "acceleration, resultant m/s²": f"{np.linalg.norm(acceleration[i]):.3g}",
                    "velocity, largest axis mm/s": f"{velocity[i, top]:.3g} ({part.axis.values[top]})",
                    "velocity, resultant mm/s": f"{np.linalg.norm(velocity[i]):.3g}",
                }
            )
    return grid("RMS levels of this run; velocity from 10 to 1000 Hz (ISO 20816-1)", rows)


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
