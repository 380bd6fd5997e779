"""The squared envelope of a band."""

from __future__ import annotations

import numpy as np


def squared_envelope(signal: np.ndarray, share: tuple[float, float]) -> np.ndarray:
    """Squared envelope (..., time) of a band, whose ends are shares of the sampling rate; of even steps of any kind."""
    lines = np.fft.fft(signal, axis=-1)
    place = np.fft.fftfreq(signal.shape[-1])
    lines *= 2.0 * ((place >= share[0]) & (place < share[1]))
    return np.abs(np.fft.ifft(lines, axis=-1)) ** 2
