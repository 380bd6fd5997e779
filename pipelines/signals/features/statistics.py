"""Statistics of a signal over time that vibration monitoring uses, per channel."""

from __future__ import annotations

import numpy as np


def statistics(signal: np.ndarray) -> dict[str, np.ndarray]:
    """The features of the whole machine (...,) of signals (..., time), see `definitions`.

    Ratios of a signal that is constant are NaN.
    """
    x = np.asarray(signal, dtype=float)
    rms, peak = root_mean_square(x), np.abs(x).max(axis=-1)
    return {
        "rms": rms,
        "peak": peak,
        "crest_factor": _ratio(peak, rms),
        "kurtosis": kurtosis(x),
        "skewness": _moment_ratio(x, 3),
    }


def squared_magnitude(x: np.ndarray) -> np.ndarray:
    """|x|^2 of complex values, without the square root in `abs`."""
    return np.asarray(x.real**2 + x.imag**2)


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
