"""A band of a signal as it is, and with its spectrum whitened.

Impacts have wide spectra. Resonances, and lines that deviations and other components cause, hide them: whitening gives
every part of the band the same power, so that impacts stand out where the rest is low.

References
----------
Borghesani, Pennacchi, Randall, Sawalhi & Ricci (2013), Mech. Syst. Signal Process. 36(2), 370-384 (whitening of every
line by its own amplitude; here by that of its surroundings).
"""

from __future__ import annotations

import numpy as np
from scipy import fft

_LEAST = 1e-20  # of the mean power: a part of the band without power stays without


def banded(signal: np.ndarray, share: tuple[float, float], width: float) -> tuple[np.ndarray, np.ndarray]:
    """Complex signals (..., time) of a band: as it is, and each line divided by the rms amplitude of those around it.

    The real part is the filtered signal, the absolute value its envelope.

    Parameters
    ----------
    signal : (..., time), at even steps of any kind
    share : ends of the band as shares of the sampling rate, up to 0.5
    width : the same, of the range of lines around one
    """
    size = signal.shape[-1]
    first, last = (int(np.ceil(end * size)) for end in share)
    lines = 2.0 * fft.rfft(signal, axis=-1)[..., first:last]
    total = np.zeros((*signal.shape[:-1], last - first + 1))
    np.cumsum(lines.real**2 + lines.imag**2, axis=-1, out=total[..., 1:])
    reach, place = max(int(0.5 * width * size), 1), np.arange(last - first)
    low, high = np.maximum(place - reach, 0), np.minimum(place + reach + 1, last - first)
    power = (total[..., high] - total[..., low]) / (high - low)
    least = _LEAST * total[..., -1:] + np.finfo(float).tiny
    laid = np.zeros(signal.shape, dtype=complex)
    laid[..., first:last] = lines
    plain = fft.ifft(laid, axis=-1)
    laid[..., first:last] = lines / np.sqrt(np.maximum(power, least))
    return plain, fft.ifft(laid, axis=-1)
