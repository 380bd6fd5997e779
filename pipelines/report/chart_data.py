"""Interactive charts within the page, without external files: signals and spectra in compact form, shown by uPlot.

The channel of the verdict keeps every sample. The others keep the smallest and largest value of every interval of a
signal, and the largest line of every interval of a spectrum. Signals are 16-bit numbers with a scale (every sample of
the verdict's channel: 32-bit floats), spectra the logarithm of their amplitudes in steps of 1/2000 of a decade, 0.06 %
of the value. Figures of the class "static" replace them without scripts, and on paper.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import xarray

from pipelines.report import page
from pipelines.report.figures.colours import FAULTY, HEALTHY
from pipelines.signals.analysis import DiagnosisSettings, analyse, channel, channel_names

POINTS = 4_000  # of every curve but those of the verdict's channel
MOST_POINTS = 200_000  # of a curve of the verdict's channel: more would make the page larger than 5 MB
LEVELS = 32_767  # of a 16-bit number
STEP = 1 / 2_000  # of a decade
LEAST = 1e-15  # m/s2, in place of an amplitude of zero
ENVELOPE_ORDERS = 12.5  # of f_r, range of an envelope spectrum


def charts(
    runs: Mapping[str, xarray.Dataset],
    first: tuple[str, str],
    settings: DiagnosisSettings | None,
    band: tuple[float, float] | None,
    windows: Mapping[str, tuple[float, float]],
) -> str:
    """HTML element with the charts, their data, style and scripts.

    Parameters
    ----------
    runs : responses by name, one run or a run and its control; names of healthy ones begin with "healthy"
    first : sensor and axis of the verdict
    settings : windows and lines of the spectra, None for signals alone
    band : Hz, of the envelope
    windows : of the diagnosis, (start, end) in s, shaded in the signal
    """
    data = {
        "runs": [{"name": name, "colour": HEALTHY if name.startswith("healthy") else FAULTY} for name in runs],
        "windows": [[name, *span] for name, span in windows.items()],
        "views": views(settings, band),
        "channels": list(_channels(runs, first, settings, band)),
    }
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    licence = page.asset("uPlot-LICENSE.txt")
    return (
        f'<style>{page.asset("uPlot.min.css")}</style><div id="zoom"></div>\n'
        f'<script type="application/json" id="zoom-data">{text}</script>\n'
        f"<script>/*\n{licence}*/\n{page.asset('uPlot.iife.min.js')}</script>\n<script>{page.asset('zoom.js')}</script>"
    )


def views(settings: DiagnosisSettings | None, band: tuple[float, float] | None) -> list[dict[str, Any]]:
    """Charts of a run: its signal and, with settings, spectrum and envelope spectrum of every window.

    Each has a title, the window of its spectrum ("" for signals), axes with units, and `marks` of places with labels.
    """
    common = {"window": "", "across": "time, s", "up": "acceleration, m/s²", "logarithmic": False, "marks": ()}
    found = [common | {"title": "Signal without sensor noise"}]
    if settings is None or band is None:
        return found
    f_r, f_m = settings.revolution_frequency, settings.mesh_frequency
    meshes = [(n * f_m, "fₘ" if n == 1 else f"{n} fₘ") for n in range(1, 9)]
    turns = [(k * f_r, "fᵣ" if k == 1 else f"{k} fᵣ") for k in range(1, settings.envelope_harmonics + 1)]
    common = {"across": "frequency, Hz", "up": "amplitude, m/s²", "logarithmic": True}
    envelope = f"Envelope spectrum, band {band[0]:.4g} to {band[1]:.4g} Hz"
    for window in settings.windows:
        found.append(common | {"title": "Spectrum", "window": window, "marks": meshes})
        found.append(common | {"title": envelope, "window": window, "marks": turns})
    return found


def streams(count: int) -> tuple[int, ...]:
    """Numbers of the noise of one run, or of a run and its control, as in the diagnosis."""
    return (1, 0) if count > 1 else (0,)


def _channels(
    runs: Mapping[str, xarray.Dataset],
    first: tuple[str, str],
    settings: DiagnosisSettings | None,
    band: tuple[float, float] | None,
) -> Iterator[dict[str, Any]]:
    """Every sensor and axis that all runs have, with its traces by view and, within a view, by run.

    The channels of the verdict's sensor are first; the verdict's own one is complete.
    """
    known = [channel_names(run) for run in runs.values()]
    sensors = [name for name in known[0] if all(name in others for others in known)]
    for sensor in sorted(sensors, key=lambda name: name != first[0]):
        found = [
            dict(_of_sensor(run, sensor, first, settings, band, stream))
            for run, stream in zip(runs.values(), streams(len(runs)), strict=True)
        ]
        for axis in sorted(found[0], key=lambda axis: (sensor, axis) != first):
            if all(axis in traces for traces in found):
                stretch = max(stretch for traces in found for _, stretch in traces[axis])
                yield {
                    "name": f"{sensor} {axis}",
                    "note": _note((sensor, axis) == first, stretch),
                    "traces": list(zip(*([trace for trace, _ in traces[axis]] for traces in found), strict=True)),
                }


def _note(exact: bool, stretch: int) -> str:
    """Description of the reduction of a channel, whose intervals have `stretch` samples."""
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
) -> Iterator[tuple[str, list[tuple[dict[str, Any], int]]]]:
    """Traces of one run by axis that the sensor has, in the order of `views`, each with the samples in an interval."""
    signal = channel(run, sensor).transpose("time", "axis").values.astype(float)
    spectra = list(_spectra(run, sensor, settings, band, stream)) if settings is not None and band is not None else []
    start, end = run.time.values[[0, -1]]
    step = float(end - start) / (len(signal) - 1)
    for i, axis in enumerate(map(str, run.axis.values)):
        if np.isnan(signal[:, i]).any():
            continue  # the sensor does not have this axis
        exact = (sensor, axis) == first
        most = MOST_POINTS if exact else POINTS
        values, stretch = extremes(signal[:, i], most)
        half = step * stretch / 2  # the two points of an interval are at a quarter and at three quarters of it
        place = (float(start), step) if stretch == 1 else (float(start) + half / 2, half)
        found = [(_packed(values, *place, exact=exact), stretch)]
        for amplitude, resolution in spectra:
            values, stretch = largest(amplitude[:, i], most)
            numbers = np.rint(np.log10(np.maximum(values, LEAST)) / STEP)
            place = (stretch - 1) * resolution / 2, stretch * resolution
            found.append((_stored(numbers.astype("<i2"), STEP, *place), stretch))
        yield axis, found


def _packed(values: np.ndarray, start: float, step: float, *, exact: bool) -> dict[str, Any]:
    """A signal at even steps from `start`: every sample exact, or 16-bit numbers with a scale."""
    if exact:
        return _stored(values.astype("<f4"), 1.0, start, step)
    scale = float(np.abs(values).max()) / LEVELS or 1.0
    return _stored(np.rint(values / scale).astype("<i2"), scale, start, step)


def _stored(numbers: np.ndarray, scale: float, start: float, step: float) -> dict[str, Any]:
    """A trace as base64 of little-endian numbers, with their type and scale."""
    data = base64.b64encode(numbers.tobytes()).decode("ascii")
    return {"start": start, "step": step, "scale": scale, "kind": numbers.dtype.str[1:], "data": data}


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
