"""The band of the envelope: the one with the greatest kurtosis above half of the mesh frequency.

Below that guard lie the orders of the shafts, whose few strong lines beat and are taken for impulses: without it a
healthy machine gave a band from 0 to 78 Hz. The bands halve and third what lies above the guard, level by level.

References
----------
Antoni (2006), Mech. Syst. Signal Process. 20(2), 282-307 (spectral kurtosis of the complex envelope); Antoni (2007),
Mech. Syst. Signal Process. 21(1), 108-124 (1/3-binary tree of bands).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

HIGHEST = 0.45  # of the sampling rate; filters of recorders roll off above
PARTS = (1, 2, 3, 4, 6, 8)  # of equal width into which the range above the guard is divided


def candidate_bands(low: float, high: float) -> Iterator[tuple[float, float]]:
    """All bands between two frequencies."""
    for parts in PARTS:
        edges = np.linspace(low, high, parts + 1)
        yield from ((float(a), float(b)) for a, b in zip(edges[:-1], edges[1:], strict=True))


def guarded_band(signal: np.ndarray, rate: float, guard: float) -> tuple[float, float]:
    """The band (Hz) whose complex envelope has the greatest kurtosis in the mean over the channels.

    Parameters
    ----------
    signal : (channel, time), at a rate (Hz)
    rate : Hz
    guard : Hz, nothing below it is looked at: half of the lowest mesh frequency

    Raises
    ------
    ValueError : the guard leaves nothing below HIGHEST of the rate
    """
    high = HIGHEST * rate
    if not guard < high:
        raise ValueError(f"no band above {guard:g} Hz: the rate of {rate:g} Hz reaches {high:g} Hz")
    lines = np.fft.fft(signal, axis=-1)
    frequency = np.fft.fftfreq(signal.shape[-1], 1.0 / rate)
    found = {band: _kurtosis(lines, frequency, band) for band in candidate_bands(guard, high)}
    return max(found, key=lambda band: found[band])


def _kurtosis(lines: np.ndarray, frequency: np.ndarray, band: tuple[float, float]) -> float:
    """<|x|^4> / <|x|^2>^2 - 2 of the complex envelope x, 0 for Gaussian noise, in the mean over the channels."""
    inside = np.flatnonzero((frequency >= band[0]) & (frequency < band[1]))
    size = 2 * len(inside)  # the envelope of a band needs no more samples than twice its lines
    part = np.zeros((len(lines), size), dtype=complex)
    part[:, : len(inside)] = lines[:, inside]
    power = np.abs(np.fft.ifft(part, axis=-1)) ** 2
    mean = power.mean(axis=-1)
    kurtosis = np.divide((power**2).mean(axis=-1), mean**2, out=np.zeros_like(mean), where=mean > 0.0)
    return float(kurtosis.mean() - 2.0)


def squared_envelope(signal: np.ndarray, share: tuple[float, float]) -> np.ndarray:
    """Squared envelope (..., time) of a band, whose ends are shares of the sampling rate; of even steps of any kind."""
    lines = np.fft.fft(signal, axis=-1)
    place = np.fft.fftfreq(signal.shape[-1])
    lines *= 2.0 * ((place >= share[0]) & (place < share[1]))
    return np.abs(np.fft.ifft(lines, axis=-1)) ** 2
