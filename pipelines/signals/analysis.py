"""Spectrum and envelope spectrum of one run: a channel with noise, cut to whole revolutions.

The settings select the band of the envelope by one of these rules. None of them uses the faulty run.

- "mesh" (default): f_m/2 to 3 f_m/2. It contains the sidebands that are closer to the first mesh order than to its
  neighbours (McFadden 1986, J. Vib. Acoust. 108, 165).
- "resonance": a band as wide as the mesh frequency, above the sidebands of the second mesh order and below 0.4 of the
  sampling rate. The one with the highest energy in the healthy run is taken, since impacts excite casing resonances.
- a pair of frequencies in Hz.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from pipelines.signals.pass_lines import PassLines
from pipelines.signals.shaft_lines import ShaftLines
from pipelines.signals.spectrum import (
    Segment,
    Spectrum,
    amplitude_spectrum,
    cut,
    envelope_spectrum,
    whole_revolutions,
    with_noise,
)

if TYPE_CHECKING:
    import xarray

SPEED_TOLERANCE = 1e-3  # relative to f_r, for the mean speed of the monitored shaft in the segment


class DiagnosisError(ValueError):
    """Two runs cannot be compared, or a run lacks data that the diagnosis needs."""


@dataclass(frozen=True, kw_only=True)
class DiagnosisSettings:
    """Channel, windows and monitored lines of a diagnosis.

    `windows` maps names to (start, end) in s of the record's time, `rope_mode` names of windows to Hz (empty for a
    constant torque). The monitored lines are harmonics of `revolution_frequency` in the envelope, sidebands of the
    `mesh_harmonics`, `passes` of spalled bearings and `turning` lines of faulty shafts. `bearings` maps names such as
    "bearing_3 BPFO" to Hz: lines that are listed for reference. `axis` is "resultant" or an axis of the sensor.
    `shaft` carries the monitored gear; its speed is checked if it is given. If not `speed_is_known`, the frequencies
    are estimates, see `pipelines.signals.measured_speed`.
    """

    revolution_frequency: float
    mesh_frequency: float
    windows: Mapping[str, tuple[float, float]]
    rope_mode: Mapping[str, float] = field(default_factory=dict)
    bearings: Mapping[str, float] = field(default_factory=dict)
    passes: tuple[PassLines, ...] = ()
    turning: tuple[ShaftLines, ...] = ()
    sensor: str
    axis: str = "resultant"
    band: str | tuple[float, float] = "mesh"
    envelope_harmonics: int = 5
    sideband_orders: int = 4
    mesh_harmonics: tuple[int, ...] = (1, 2)
    difference_limit: float = 6.0
    floor_limit: float = 10.0
    shaft: str | None = None
    speed_is_known: bool = True

    @property
    def highest_line(self) -> float:
        """Frequency (Hz) of the highest monitored sideband."""
        return max(self.mesh_harmonics) * self.mesh_frequency + self.sideband_orders * self.revolution_frequency


@dataclass(frozen=True, eq=False, kw_only=True)
class Analysis:
    """Segments, spectra and envelope spectra of one run by window; `band` (Hz) is that of the envelope."""

    band: tuple[float, float]
    segments: Mapping[str, Segment]
    spectra: Mapping[str, Spectrum]
    envelopes: Mapping[str, Spectrum]


def analyse(
    run: xarray.Dataset, settings: DiagnosisSettings, *, stream: int = 0, band: tuple[float, float] | None = None
) -> Analysis:
    """Spectra of one run in every window.

    Parameters
    ----------
    run : signals of the run
    settings : channel, windows and lines of the diagnosis
    stream : number of the noise sequence, 0 for the healthy run, 1 for the faulty one
    band : Hz, of the envelope; if None, by the rule of the settings applied to this run

    Raises
    ------
    DiagnosisError : sensor or axis missing, samples not equidistant, or the shaft does not turn at f_r
    SpectrumError : a window contains no whole revolution
    """
    rate, begin = sampling(run)
    signal = noisy_signal(run, settings, stream)
    segments, spectra, pieces = {}, {}, {}
    for name, (start, end) in settings.windows.items():
        segment = whole_revolutions((start - begin, end - begin), rate, settings.revolution_frequency)
        _check_speed(run, rate, segment, settings, name)
        segments[name], pieces[name] = segment, cut(signal, rate, segment)
        spectra[name] = amplitude_spectrum(pieces[name], segment)
    chosen = envelope_band(settings, list(spectra.values()), rate) if band is None else band
    envelopes = {name: envelope_spectrum(pieces[name], segment, chosen) for name, segment in segments.items()}
    return Analysis(band=chosen, segments=segments, spectra=spectra, envelopes=envelopes)


def envelope_band(settings: DiagnosisSettings, healthy: Sequence[Spectrum], rate: float) -> tuple[float, float]:
    """Band of the envelope in Hz by the rule of the settings, see the docstring of this module."""
    if not isinstance(settings.band, str):
        return settings.band
    mesh = settings.mesh_frequency
    if settings.band == "mesh":
        return (mesh / 2, 1.5 * mesh)
    starts = np.arange(2.5 * mesh, 0.4 * rate - mesh, mesh / 4)
    if starts.size == 0:
        raise DiagnosisError(
            f"envelope band 'resonance': no strip of {mesh:g} Hz between {2.5 * mesh:g} Hz and {0.4 * rate:g} Hz "
            "(0.4 of the sampling rate). Use the band 'mesh'."
        )

    def energy(start: float) -> float:
        inside = [(one.frequency >= start) & (one.frequency <= start + mesh) for one in healthy]
        return sum(float(np.sum(one.amplitude[part] ** 2)) for one, part in zip(healthy, inside, strict=True))

    best = max(starts.tolist(), key=energy)
    return (best, best + mesh)


def channel_names(run: xarray.Dataset) -> list[str]:
    """Names of the channels of a run: its sensors, and without a casing the journals of its bearings."""
    sensors = [str(v) for v in run.sensor.values] if "acceleration" in run else []
    return sensors + ([str(v) for v in run.bearing.values] if "journal_acceleration" in run else [])


def channel(run: xarray.Dataset, name: str) -> xarray.DataArray:
    """Acceleration (time, axis), m/s2, at a sensor or at the journal of a bearing.

    Raises
    ------
    DiagnosisError : the run has no such channel
    """
    known = channel_names(run)
    if name not in known:
        raise DiagnosisError(
            f"sensor {name!r} is not in this run. Set a sensor of the run: {', '.join(known) or 'it has none'}."
        )
    if "acceleration" in run and name in run.sensor.values:
        return run.acceleration.sel(sensor=name)
    return run.journal_acceleration.sel(bearing=name)


def noise_of(run: xarray.Dataset) -> float:
    """Sensor noise that a run states, m/s2 rms."""
    return float(run.attrs.get("sensor_noise_m_s2", 0.0))


def noisy_signal(run: xarray.Dataset, settings: DiagnosisSettings, stream: int) -> np.ndarray:
    """Signals (time, axis) of the monitored channel with the stated noise, see `noisy_channel`."""
    axes = [str(axis) for axis in run.axis.values] if settings.axis == "resultant" else [settings.axis]
    return noisy_channel(run, settings.sensor, axes, stream)


def noisy_channel(run: xarray.Dataset, sensor: str, axes: Sequence[str], stream: int) -> np.ndarray:
    """Signals (time, axis) at a sensor or journal, with the stated noise.

    The seed of the noise follows from the seed of the deviations, the load, the stream, the sensor and the axis.

    Parameters
    ----------
    run : signals of the run
    sensor : name of a sensor, or of a bearing for its journal
    axes : names of axes
    stream : number of the noise sequence
    """
    signal = channel(run, sensor)
    known = [str(axis) for axis in run.axis.values]
    # names, not indices, enter the seed: the noise must not depend on which other sensors were recorded
    words = (str(run.attrs.get("seed", "none")), str(run.attrs.get("load", "")), sensor)
    fixed = [stream, *(zlib.crc32(word.encode()) for word in words)]
    columns = [with_noise(signal.sel(axis=axis).values, noise_of(run), [*fixed, known.index(axis)]) for axis in axes]
    return np.stack(columns, axis=1)


def sampling(run: xarray.Dataset) -> tuple[float, float]:
    """Sampling rate (Hz) and time of the first sample (s) of a run.

    Raises
    ------
    DiagnosisError : the samples are not equidistant, or fewer than two
    """
    time = np.asarray(run.time.values, dtype=float)
    steps = np.diff(time)
    if time.size < 2 or np.ptp(steps) > 1e-6 * steps.mean():
        raise DiagnosisError("time: the samples must be equidistant, at least two of them")
    rate = (time.size - 1) / (time[-1] - time[0])
    whole = float(round(rate))
    return (whole if abs(rate - whole) < 1e-6 * rate else rate), float(time[0])


def _check_speed(run: xarray.Dataset, rate: float, segment: Segment, settings: DiagnosisSettings, window: str) -> None:
    if settings.shaft is None or "shaft_speed" not in run:
        return
    first = round(segment.start * rate)
    last = first + round(segment.duration * rate)
    speed = run.shaft_speed.sel(shaft=settings.shaft).isel(time=slice(first, last)).values
    frequency = abs(float(speed.mean())) / (2 * np.pi)
    if abs(frequency / settings.revolution_frequency - 1) > SPEED_TOLERANCE:
        raise DiagnosisError(
            f"window {window!r}: {settings.shaft} turns at {frequency:.4f} Hz in the mean, but the lines need "
            f"{settings.revolution_frequency:.4f} Hz within {100 * SPEED_TOLERANCE:g} %. Choose a window at constant "
            "speed."
        )
