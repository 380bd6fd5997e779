"""Data of the interactive charts: signals, spectra and envelope spectra of every channel, reduced if they are long.

The channel of the verdict keeps every sample. The others keep the smallest and largest value of every interval of a
signal, and the largest line of every interval of a spectrum.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from pipelines.signals.analysis import DiagnosisSettings, analyse, channel, channel_names

if TYPE_CHECKING:
    import xarray

POINTS = 4_000  # of every curve but those of the verdict's channel
MOST_POINTS = 200_000  # of a curve of the verdict's channel: more would make the page larger than 5 MB
ENVELOPE_ORDERS = 12.5  # of f_r, range of an envelope spectrum


@dataclass(frozen=True, eq=False, kw_only=True)
class Trace:
    """Values at even steps: float (n,) from `start`, both in the unit of the axis."""

    start: float
    step: float
    values: np.ndarray


@dataclass(frozen=True, kw_only=True)
class ChartView:
    """A chart: its title, the window of its spectrum ("" for signals), axes with units, labelled places."""

    title: str
    window: str = ""
    across: str
    up: str
    logarithmic: bool = False
    marks: tuple[tuple[float, str], ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True)
class ChartChannel:
    """A sensor and axis with its traces by view and, within a view, by run; `note` describes the reduction."""

    name: str
    note: str
    traces: tuple[tuple[Trace, ...], ...]
    exact: bool


def views(settings: DiagnosisSettings | None, band: tuple[float, float] | None) -> tuple[ChartView, ...]:
    """Charts of a run: its signal and, with settings, spectrum and envelope spectrum of every window."""
    up = "acceleration, m/s²"
    found = [ChartView(title="Signal without sensor noise", across="time, s", up=up)]
    if settings is None or band is None:
        return tuple(found)
    f_r, f_m = settings.revolution_frequency, settings.mesh_frequency
    meshes = tuple((n * f_m, "fₘ" if n == 1 else f"{n} fₘ") for n in range(1, 9))
    turns = tuple((k * f_r, "fᵣ" if k == 1 else f"{k} fᵣ") for k in range(1, settings.envelope_harmonics + 1))
    words, low_high = "amplitude, m/s²", f"{band[0]:.4g} to {band[1]:.4g} Hz"
    for window in settings.windows:
        found += [
            ChartView(
                title="Spectrum", window=window, across="frequency, Hz", up=words, logarithmic=True, marks=meshes
            ),
            ChartView(
                title=f"Envelope spectrum, band {low_high}",
                window=window,
                across="frequency, Hz",
                up=words,
                logarithmic=True,
                marks=turns,
            ),
        ]
    return tuple(found)


def streams(count: int) -> tuple[int, ...]:
    """Numbers of the noise of one run, or of a run and its control, as in the diagnosis."""
    return (1, 0) if count > 1 else (0,)


def channels(
    runs: Mapping[str, xarray.Dataset],
    first: tuple[str, str],
    settings: DiagnosisSettings | None,
    band: tuple[float, float] | None,
) -> Iterator[ChartChannel]:
    """Every sensor and axis that all runs have, that of the verdict's sensor first and the verdict's own in full.

    Parameters
    ----------
    runs : responses by name, one run or a run and its control
    first : sensor and axis of the verdict
    settings : windows and lines of the spectra, None for signals alone
    band : Hz, of the envelope
    """
    known = [channel_names(run) for run in runs.values()]
    sensors = [name for name in known[0] if all(name in others for others in known)]
    for sensor in sorted(sensors, key=lambda name: name != first[0]):
        found = [
            list(_of_sensor(run, sensor, first, settings, band, stream))
            for run, stream in zip(runs.values(), streams(len(runs)), strict=True)
        ]
        axes = [str(axis) for axis in next(iter(runs.values())).axis.values]
        order = sorted(range(len(axes)), key=lambda i: (sensor, axes[i]) != first)
        for i in order:
            exact = (sensor, axes[i]) == first
            by_run = [traces[i] for traces in found]
            if any(np.isnan(traces[0][0].values).any() for traces in by_run):
                continue  # the sensor does not have this axis
            yield ChartChannel(
                name=f"{sensor} {axes[i]}",
                note=_note(exact, max(stretch for traces in by_run for _, stretch in traces)),
                traces=tuple(zip(*([trace for trace, _ in traces] for traces in by_run), strict=True)),
                exact=exact,
            )


def _note(exact: bool, stretch: int) -> str:
    if stretch == 1:
        return "Every sample is shown."
    kept = (
        f"Each curve has at most {MOST_POINTS if exact else POINTS} points: the extremes of each interval of a signal, "
        "and the largest line of each interval of a spectrum."
    )
    return kept if exact else f"{kept} The channel of the verdict is shown in full."


def _of_sensor(
    run: xarray.Dataset,
    sensor: str,
    first: tuple[str, str],
    settings: DiagnosisSettings | None,
    band: tuple[float, float] | None,
    stream: int,
) -> Iterator[list[tuple[Trace, int]]]:
    """Traces of one run by axis, in the order of `views`, each with the number of samples in an interval."""
    signal = channel(run, sensor).transpose("time", "axis").values.astype(float)
    spectra = list(_spectra(run, sensor, settings, band, stream)) if settings is not None and band is not None else []
    time = run.time.values
    step = float(time[-1] - time[0]) / (len(time) - 1)
    for i, axis in enumerate(run.axis.values):
        most = MOST_POINTS if (sensor, str(axis)) == first else POINTS
        found = [_signal(signal[:, i], float(time[0]), step, most)]
        yield found + [_lines(amplitude[:, i], resolution, most) for amplitude, resolution in spectra]


def _signal(signal: np.ndarray, start: float, step: float, most: int) -> tuple[Trace, int]:
    values, stretch = extremes(signal, most)
    if stretch == 1:
        return Trace(start=start, step=step, values=values), 1
    half = step * stretch / 2  # the two points of an interval are at a quarter and at three quarters of it
    return Trace(start=start + half / 2, step=half, values=values), stretch


def _spectra(
    run: xarray.Dataset, sensor: str, settings: DiagnosisSettings, band: tuple[float, float], stream: int
) -> Iterator[tuple[np.ndarray, float]]:
    """Spectrum and envelope spectrum (bin, axis) of every window, each with its resolution in Hz; with sensor noise."""
    axes = [replace(settings, sensor=sensor, axis=str(axis)) for axis in run.axis.values]
    found = [analyse(run, of_axis, stream=stream, band=band) for of_axis in axes]
    for window in settings.windows:
        spectra, envelopes = ([getattr(one, kind)[window] for one in found] for kind in ("spectra", "envelopes"))
        shown = envelopes[0].frequency <= ENVELOPE_ORDERS * settings.revolution_frequency
        yield np.stack([one.amplitude for one in spectra], axis=1), spectra[0].resolution
        yield np.stack([one.amplitude[shown] for one in envelopes], axis=1), envelopes[0].resolution


def _lines(amplitude: np.ndarray, resolution: float, most: int) -> tuple[Trace, int]:
    values, stretch = largest(amplitude, most)
    return Trace(start=(stretch - 1) * resolution / 2, step=stretch * resolution, values=values), stretch


def extremes(values: np.ndarray, most: int) -> tuple[np.ndarray, int]:
    """Smallest and largest value of intervals, in their order in time, and the number of samples in an interval.

    Parameters
    ----------
    values : float (n,)
    most : largest number of points, an even number

    Returns
    -------
    float (at most `most`,), two per interval, and the samples in one; the values themselves and 1 if they are few
    """
    if len(values) <= most:
        return values, 1
    stretch = -(-2 * len(values) // most)
    laid = _laid(values, stretch)
    low, high = laid.argmin(axis=1), laid.argmax(axis=1)
    places = np.stack([np.minimum(low, high), np.maximum(low, high)], axis=1)
    return np.take_along_axis(laid, places, axis=1).ravel(), stretch


def largest(values: np.ndarray, most: int) -> tuple[np.ndarray, int]:
    """Largest value of every interval, at most `most`, and the number of samples in an interval, of float (n,)."""
    if len(values) <= most:
        return values, 1
    stretch = -(-len(values) // most)
    return _laid(values, stretch).max(axis=1), stretch


def _laid(values: np.ndarray, stretch: int) -> np.ndarray:
    """Rows of an interval each; the last one is filled up with the last value."""
    missing = -len(values) % stretch
    return np.concatenate([values, np.full(missing, values[-1])]).reshape(-1, stretch)
