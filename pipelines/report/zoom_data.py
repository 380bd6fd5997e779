"""What the charts that zoom show: signals, spectra and envelope spectra of every channel, thinned where they are many.

The channel of the verdict keeps every sample; of the others stay the smallest and largest value of every stretch of a
signal, and the largest line of every stretch of a spectrum.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from pipelines.report.thinning import extremes, largest
from pipelines.signals.analysis import DiagnosisSettings, analyse, channel, channel_names
from pipelines.signals.spectrum import Spectrum

if TYPE_CHECKING:
    import xarray

POINTS = 4_000  # of every curve but those of the verdict's channel
MOST_POINTS = 200_000  # of a curve of the verdict's channel: more would make the page larger than 5 MB
ENVELOPE_ORDERS = 12.5  # of f_r, how far an envelope spectrum is shown


@dataclass(frozen=True, eq=False, kw_only=True)
class Trace:
    """Values at even steps: float (n,) from `start`, both in the unit of the axis."""

    start: float
    step: float
    values: np.ndarray


@dataclass(frozen=True, kw_only=True)
class View:
    """A chart: its title, the window whose spectrum it is ("" for signals), axes with units, places that are named."""

    title: str
    window: str = ""
    across: str
    up: str
    logarithmic: bool = False
    marks: tuple[tuple[float, str], ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True)
class Channel:
    """A sensor and axis with its traces by view and, within a view, by run; `note` says what was thinned."""

    name: str
    note: str
    traces: tuple[tuple[Trace, ...], ...]
    exact: bool


def views(settings: DiagnosisSettings | None, band: tuple[float, float] | None) -> tuple[View, ...]:
    """The charts of a run: its signal and, where there are settings, spectrum and envelope spectrum of every window."""
    up = "acceleration, m/s²"
    found = [View(title="Signal without sensor noise", across="time, s", up=up)]
    if settings is None or band is None:
        return tuple(found)
    f_r, f_m = settings.revolution_frequency, settings.mesh_frequency
    meshes = tuple((n * f_m, "f_m" if n == 1 else f"{n} f_m") for n in range(1, 9))
    turns = tuple((k * f_r, "f_r" if k == 1 else f"{k} f_r") for k in range(1, settings.envelope_harmonics + 1))
    words, low_high = "amplitude, m/s²", f"{band[0]:.4g} to {band[1]:.4g} Hz"
    for window in settings.windows:
        found += [
            View(title="Spectrum", window=window, across="frequency, Hz", up=words, logarithmic=True, marks=meshes),
            View(
                title=f"Envelope spectrum, band {low_high}",
                window=window,
                across="frequency, Hz",
                up=words,
                logarithmic=True,
                marks=turns,
            ),
        ]
    return tuple(found)


def channels(
    runs: Mapping[str, xarray.Dataset],
    first: tuple[str, str],
    settings: DiagnosisSettings | None,
    band: tuple[float, float] | None,
) -> Iterator[Channel]:
    """Every sensor and axis that all runs have, that of the verdict first and in full.

    Parameters
    ----------
    runs : responses by name
    first : sensor and axis of the verdict
    settings : windows and lines of the spectra, None for signals alone
    band : Hz, of the envelope
    """
    known = [set(_names(run)) for run in runs.values()]
    names = [name for name in _names(next(iter(runs.values()))) if all(name in others for others in known)]
    for sensor, axis in sorted(names, key=lambda name: name != first):
        exact = (sensor, axis) == first
        most = MOST_POINTS if exact else POINTS
        by_run = [list(_traces(run, sensor, axis, settings, band, most)) for run in runs.values()]
        stretches = {one for traces in by_run for _, one in traces}
        yield Channel(
            name=f"{sensor} {axis}",
            note=_note(most, exact, max(stretches)),
            traces=tuple(zip(*([trace for trace, _ in traces] for traces in by_run), strict=True)),
            exact=exact,
        )


def _names(run: xarray.Dataset) -> list[tuple[str, str]]:
    return [(sensor, str(axis)) for sensor in channel_names(run) for axis in run.axis.values]


def _note(most: int, exact: bool, stretch: int) -> str:
    if stretch == 1:
        return "Every sample is shown."
    kept = f"At most {most} points of every curve are kept: extremes of stretches of the signal, the largest lines."
    return kept if exact else f"{kept} The channel of the verdict is shown in full."


def _traces(
    run: xarray.Dataset,
    sensor: str,
    axis: str,
    settings: DiagnosisSettings | None,
    band: tuple[float, float] | None,
    most: int,
) -> Iterator[tuple[Trace, int]]:
    """The traces of one run in the order of `views`, each with the samples of a stretch of it."""
    time = run.time.values
    values, stretch = extremes(channel(run, sensor).sel(axis=axis).values.astype(float), most)
    step = float(time[-1] - time[0]) / (len(time) - 1)
    each = step * stretch / (1 if stretch == 1 else 2)  # two points per stretch, at a quarter and three quarters of it
    yield Trace(start=float(time[0]) + (0 if stretch == 1 else each / 2), step=each, values=values), stretch
    if settings is None or band is None:
        return
    found = analyse(run, replace(settings, sensor=sensor, axis=axis), band=band)
    for window in settings.windows:
        yield _lines(found.spectra[window], np.inf, most)
        yield _lines(found.envelopes[window], ENVELOPE_ORDERS * settings.revolution_frequency, most)


def _lines(spectrum: Spectrum, end: float, most: int) -> tuple[Trace, int]:
    amplitude = spectrum.amplitude[spectrum.frequency <= end]
    values, stretch = largest(amplitude, most)
    width = stretch * spectrum.resolution
    return Trace(start=(width - spectrum.resolution) / 2, step=width, values=values), stretch
