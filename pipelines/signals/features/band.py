"""The squared envelope of a band."""

from __future__ import annotations

import numpy as np
from scipy import fft


def squared_envelope(signal: np.ndarray, share: tuple[float, float]) -> np.ndarray:
    """Squared envelope (..., time) of a band, whose ends are shares of the sampling rate; of even steps of any kind."""
    steps = signal.shape[-1]
    first, end = np.searchsorted(np.arange(steps // 2 + 1) / steps, share)
    analytic = np.zeros(signal.shape, dtype=complex)
    analytic[..., first:end] = 2.0 * fft.rfft(signal, axis=-1)[..., first:end]
    analytic = fft.ifft(analytic, axis=-1, overwrite_x=True)
    return np.square(analytic.real) + np.square(analytic.imag)
