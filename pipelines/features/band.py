"""The squared envelope of a band, and the highest frequency that is looked at."""

from __future__ import annotations

import numpy as np

HIGHEST = 0.45  # of the sampling rate; filters of recorders roll off above


def squared_envelope(signal: np.ndarray, share: tuple[float, float]) -> np.ndarray:
    """Squared envelope (..., time) of a band, whose ends are shares of the sampling rate; of even steps of any kind."""
    lines = np.fft.fft(signal, axis=-1)
    place = np.fft.fftfreq(signal.shape[-1])
    lines *= 2.0 * ((place >= share[0]) & (place < share[1]))
    return np.abs(np.fft.ifft(lines, axis=-1)) ** 2
