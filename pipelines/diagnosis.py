"""Diagnosis: the lines a local gear fault must raise, faulty run against its healthy control.

A fault on one tooth repeats with the revolution frequency f_r of its shaft. It modulates the mesh: harmonics of f_r
in the envelope and sidebands n f_m + k f_r in the spectrum. Pitch deviations repeat with the same revolution and put
the same lines into a healthy run, so a line stands only if it rises over the control with the same deviations
(6 dB) and over the local floor between the orders (10 dB), both with the stated sensor noise.

Bands of the envelope. None of the rules looks at the faulty run.
- "mesh" (default): f_m/2 to 3 f_m/2, the sidebands that belong to the first mesh order rather than to a neighbour
  (the widest narrow-band demodulation around f_m; McFadden 1986, J. Vib. Acoust. 108, 165).
- "resonance": the strip one mesh order wide, above the sidebands of the second mesh order and below 0.4 of the
  sampling rate, in which the healthy run carries most energy: a casing resonance that impacts would ring.
- a pair of frequencies in Hz.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.lines import LineTable, joined, level
from pipelines.spectrum import (
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

STATES = ("faulty", "healthy")
SPEED_TOLERANCE = 1e-3  # of f_r, for the mean speed of the faulty shaft over the segment
LINE_WIDTH = 2.0  # bins; a rope mode this close to a line cannot be told from it


class DiagnosisError(ValueError):
    """Two runs cannot be compared, or a run lacks what the diagnosis needs."""


@dataclass(frozen=True, kw_only=True)
class DiagnosisSettings:
    """What is looked for, where.

    `windows` name -> (start, end) in s of the record's time; `rope_mode` window name -> Hz (none for a constant
    torque); `axis` "resultant" or an axis of the sensor; `shaft` the faulty shaft, whose speed is checked if given;
    `fault` and `reason` are words for the verdict: what is damaged, and the physical reason where nothing stands.
    """

    revolution_frequency: float
    mesh_frequency: float
    windows: Mapping[str, tuple[float, float]]
    rope_mode: Mapping[str, float] = field(default_factory=dict)
    sensor: str = "sensor_3"
    axis: str = "resultant"
    band: str | tuple[float, float] = "mesh"
    envelope_harmonics: int = 5
    sideband_orders: int = 4
    mesh_harmonics: tuple[int, ...] = (1, 2)
    spectrum_window: str = "hann"
    difference_limit: float = 6.0
    floor_limit: float = 10.0
    shaft: str | None = None
    fault: str = "fault"
    reason: str = ""

    def __post_init__(self) -> None:
        if not 0 < self.revolution_frequency < self.mesh_frequency:
            raise DiagnosisError(
                f"revolution frequency {self.revolution_frequency:g} Hz and mesh frequency {self.mesh_frequency:g} Hz: "
                "both must be positive and the mesh the faster"
            )
        if isinstance(self.band, str) and self.band not in ("mesh", "resonance"):
            raise DiagnosisError(f"envelope band {self.band!r}: give 'mesh', 'resonance' or two frequencies in Hz")
        if not self.windows:
            raise DiagnosisError("windows: none given, at least one with constant speed is needed")


@dataclass(frozen=True, eq=False, kw_only=True)
class Diagnosis:
    """One faulty run against its control: the lines, and the spectra they were read from."""

    settings: DiagnosisSettings
    load: str
    deviations: str  # "off" | "seed <n>"
    noise: float  # m/s2 rms, added to both runs
    band: tuple[float, float]  # Hz
    segments: Mapping[str, Segment]  # window -> segment
    lines: LineTable
    spectra: Mapping[tuple[str, str], Spectrum]  # (state, window)
    envelopes: Mapping[tuple[str, str], Spectrum]


def diagnose(faulty: xarray.Dataset, healthy: xarray.Dataset, settings: DiagnosisSettings) -> Diagnosis:
    """Compare two runs of one scene that differ in the fault alone.

    Parameters
    ----------
    faulty, healthy : Datasets with acceleration(time, sensor, axis) in m/s2, equal sampling, attrs load and seed

    Raises
    ------
    DiagnosisError : different load, seed or sampling; sensor or axis missing; the shaft does not turn at f_r
    SpectrumError : a window holds no whole revolution
    """
    _check_comparable(faulty, healthy)
    rate, begin = _sampling(faulty)
    signals = {"faulty": noisy_signal(faulty, settings, 1), "healthy": noisy_signal(healthy, settings, 0)}
    segments = {
        name: whole_revolutions((start - begin, end - begin), rate, settings.revolution_frequency)
        for name, (start, end) in settings.windows.items()
    }
    for name, segment in segments.items():
        for run in (faulty, healthy):
            _check_speed(run, rate, segment, settings, name)
    pieces = {
        (state, name): cut(signals[state], rate, segment) for state in STATES for name, segment in segments.items()
    }
    spectra = {
        key: amplitude_spectrum(piece, segments[key[1]], settings.spectrum_window) for key, piece in pieces.items()
    }
    band = envelope_band(settings, [spectra["healthy", name] for name in segments], rate)
    envelopes = {
        key: envelope_spectrum(piece, segments[key[1]], band, settings.spectrum_window) for key, piece in pieces.items()
    }
    load, deviations = str(faulty.attrs["load"]), deviation_name(faulty)
    lines = joined(_window_lines(settings, name, load, deviations, spectra, envelopes) for name in settings.windows)
    return Diagnosis(
        settings=settings,
        load=load,
        deviations=deviations,
        noise=float(faulty.attrs.get("sensor_noise", 0.0)),
        band=band,
        segments=segments,
        lines=lines,
        spectra=spectra,
        envelopes=envelopes,
    )


def envelope_band(settings: DiagnosisSettings, healthy: list[Spectrum], rate: float) -> tuple[float, float]:
    """Band of the envelope in Hz from the rule named in the settings; see the head of this file."""
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
    energy = np.zeros(starts.size)
    for spectrum in healthy:
        for i, start in enumerate(starts):
            inside = (spectrum.frequency >= start) & (spectrum.frequency <= start + mesh)
            energy[i] += np.sum(spectrum.amplitude[inside] ** 2)
    best = float(starts[int(np.argmax(energy))])
    return (best, best + mesh)


def noisy_signal(run: xarray.Dataset, settings: DiagnosisSettings, stream: int) -> np.ndarray:
    """The channel's signals (time, axes) with the stated noise; seed, load, stream, sensor and axis fix it."""
    sensors, axes = [str(s) for s in run.sensor.values], [str(a) for a in run.axis.values]
    if settings.sensor not in sensors:
        raise DiagnosisError(f"sensor {settings.sensor!r}: not in this run, it has {', '.join(sensors) or 'none'}")
    if settings.axis != "resultant" and settings.axis not in axes:
        raise DiagnosisError(f"axis {settings.axis!r}: give 'resultant' or one of {', '.join(axes)}")
    wanted = axes if settings.axis == "resultant" else [settings.axis]
    rms, seed = float(run.attrs.get("sensor_noise", 0.0)), int(run.attrs.get("seed", 0))
    # its number, not its index, enters the seed: the noise must not depend on which other sensors were recorded
    number = int("".join(filter(str.isdigit, settings.sensor)) or 0)
    load = zlib.crc32(str(run.attrs["load"]).encode())
    columns = []
    for axis in wanted:
        clean = run.acceleration.sel(sensor=settings.sensor, axis=axis).values
        columns.append(with_noise(clean, rms, [seed, stream, number, axes.index(axis), load]))
    return np.stack(columns, axis=1)


def deviation_name(run: xarray.Dataset) -> str:
    """ "off" for error-free gears (attribute deviations = "off"), else "seed <n>"."""
    return "off" if str(run.attrs.get("deviations", "")) == "off" else f"seed {int(run.attrs.get('seed', 0))}"


def _window_lines(
    settings: DiagnosisSettings,
    window: str,
    load: str,
    deviations: str,
    spectra: Mapping[tuple[str, str], Spectrum],
    envelopes: Mapping[tuple[str, str], Spectrum],
) -> LineTable:
    f_r, f_m = settings.revolution_frequency, settings.mesh_frequency
    wanted: list[tuple[str, int, int]] = [("envelope", 0, k) for k in range(1, settings.envelope_harmonics + 1)]
    for n in settings.mesh_harmonics:
        for k in range(-settings.sideband_orders, settings.sideband_orders + 1):
            wanted.append(("sideband" if k else "mesh", n, k))
    columns: dict[str, Any] = {
        "kind": [kind for kind, _, _ in wanted],
        "mesh_harmonic": np.array([n for _, n, _ in wanted]),
        "order": np.array([k for _, _, k in wanted]),
        "label": [_label(n, k) for _, n, k in wanted],
    }
    frequency = columns["mesh_harmonic"] * f_m + columns["order"] * f_r
    is_envelope = columns["mesh_harmonic"] == 0
    for state in STATES:
        columns[state], columns[f"{state}_floor"] = np.empty(len(wanted)), np.empty(len(wanted))
        for spectrum, rows in ((envelopes[state, window], is_envelope), (spectra[state, window], ~is_envelope)):
            columns[state][rows] = spectrum.lines(frequency[rows])
            columns[f"{state}_floor"][rows] = spectrum.floors(frequency[rows])
    difference = level(columns["faulty"], columns["healthy"])
    over_floor = level(columns["faulty"], columns["faulty_floor"])
    healthy_over_floor = level(columns["healthy"], columns["healthy_floor"])
    rope = float(settings.rope_mode.get(window, 0.0))
    width = LINE_WIDTH * spectra["faulty", window].resolution
    count = len(wanted)
    return LineTable(
        load_case=(load,) * count,
        deviations=(deviations,) * count,
        window=(window,) * count,
        frequency=frequency,
        difference=difference,
        over_floor=over_floor,
        healthy_over_floor=healthy_over_floor,
        stands=(difference >= settings.difference_limit) & (over_floor >= settings.floor_limit),
        healthy_shows=healthy_over_floor >= settings.floor_limit,
        rope_mode=np.full(count, rope),
        near_rope=(rope > 0) & (np.abs(np.abs(columns["order"]) * f_r - rope) <= width),
        **columns,
    )


def _label(n: int, k: int) -> str:
    order = "" if k == 0 else (f"{abs(k)} f_r" if abs(k) > 1 else "f_r")
    if n == 0:
        return order
    mesh = "f_m" if n == 1 else f"{n} f_m"
    return mesh if k == 0 else f"{mesh} {'+' if k > 0 else '-'} {order}"


def _sampling(run: xarray.Dataset) -> tuple[float, float]:
    """Rate (Hz) and time of the first sample (s) of a uniformly sampled run."""
    time = np.asarray(run.time.values, dtype=float)
    steps = np.diff(time)
    if time.size < 2 or np.ptp(steps) > 1e-6 * steps.mean():
        raise DiagnosisError("time: the samples must be equidistant, at least two of them")
    rate = (time.size - 1) / (time[-1] - time[0])
    whole = float(round(rate))
    return (whole if abs(rate - whole) < 1e-6 * rate else rate), float(time[0])


def _check_comparable(faulty: xarray.Dataset, healthy: xarray.Dataset) -> None:
    for name in ("load", "seed", "sensor_noise", "deviations"):
        left, right = faulty.attrs.get(name), healthy.attrs.get(name)
        if left != right:
            raise DiagnosisError(
                f"{name}: {left!r} in the faulty run, {right!r} in the healthy one; "
                "a control differs in the fault alone"
            )
    if "load" not in faulty.attrs:
        raise DiagnosisError("load: attribute missing in both runs, 'rope' or 'static-torque' is expected")
    if faulty.time.size != healthy.time.size or _sampling(faulty) != _sampling(healthy):
        raise DiagnosisError(
            f"time: {faulty.time.size} samples in the faulty run, {healthy.time.size} in the healthy one, "
            "or different rates; run both with the same duration and output rate"
        )


def _check_speed(run: xarray.Dataset, rate: float, segment: Segment, settings: DiagnosisSettings, window: str) -> None:
    if settings.shaft is None or "shaft_speed" not in run:
        return
    first = round(segment.start * rate)
    last = first + round(segment.duration * rate)
    speed = run.shaft_speed.sel(shaft=settings.shaft).values[first:last]
    frequency = abs(float(speed.mean())) / (2 * np.pi)
    if abs(frequency / settings.revolution_frequency - 1) > SPEED_TOLERANCE:
        raise DiagnosisError(
            f"window {window!r}: {settings.shaft} turns at {frequency:.4f} Hz in the mean, lines are looked for at "
            f"{settings.revolution_frequency:.4f} Hz (within {SPEED_TOLERANCE:g}). Choose a window at constant speed."
        )
