"""Statistics of a signal over time that vibration monitoring uses, per channel.

References
----------
ISO 13373-1:2002, 5 (rms, peak, crest factor); Dyer & Stewart (1978), J. Mech. Des. 100(2), 229-235 (kurtosis).
"""

from __future__ import annotations

import numpy as np


def statistics(signal: np.ndarray) -> dict[str, np.ndarray]:
    """Features (...,) of signals (..., time), in the unit of the signal or without one.

    With x the samples, m their mean and < > the mean over time:

    mean           m
    rms            sqrt <x^2>
    peak           max |x|
    crest_factor   peak / rms
    kurtosis       <(x - m)^4> / <(x - m)^2>^2, 3 for Gaussian noise
    skewness       <(x - m)^3> / <(x - m)^2>^(3/2)

    Ratios of a signal that is constant are NaN.
    """
    x = np.asarray(signal, dtype=float)
    rms, peak = root_mean_square(x), np.abs(x).max(axis=-1)
    return {
        "mean": x.mean(axis=-1),
        "rms": rms,
        "peak": peak,
        "crest_factor": _ratio(peak, rms),
        "kurtosis": kurtosis(x),
        "skewness": _moment_ratio(x, 3),
    }


def root_mean_square(x: np.ndarray) -> np.ndarray:
    """sqrt <x^2> over the last axis."""
    return np.sqrt(np.mean(x**2, axis=-1))


def kurtosis(x: np.ndarray) -> np.ndarray:
    """Fourth moment over the square of the second one, over the last axis."""
    return _moment_ratio(x, 4)


def _moment_ratio(x: np.ndarray, power: int) -> np.ndarray:
    away = x - x.mean(axis=-1, keepdims=True)
    squared = away * away  # products: `**` takes ten times as long
    top = squared * (squared if power == 4 else away)
    return _ratio(top.mean(axis=-1), squared.mean(axis=-1) ** (power / 2))


def _ratio(top: np.ndarray, bottom: np.ndarray) -> np.ndarray:
    return np.divide(top, bottom, out=np.full(np.shape(top), np.nan), where=bottom > 0.0)
