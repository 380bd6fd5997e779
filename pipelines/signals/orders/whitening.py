"""Band-pass filter of a signal, with and without whitening of its spectrum.

Impacts have wide spectra, but resonances and lines by deviations and other components mask them. Whitening gives every
part of the band the same power. Impacts are then visible by the parts of the band where other components are weak.

References
----------
Borghesani, Pennacchi, Randall, Sawalhi & Ricci (2013), Mech. Syst. Signal Process. 36(2), 370-384 (whitening of every
line by its own amplitude; here by that of its surroundings).
"""

from __future__ import annotations

import numpy as np
from scipy import fft

_ROUNDING = 1e-3  # lines: an end at a line includes it, also if the times of a file are rounded
_LEAST = 1e-20  # of the total power; parts of the band with less are not amplified


def banded(signal: np.ndarray, share: tuple[float, float], width: float) -> tuple[np.ndarray, np.ndarray]:
    """Analytic signals (..., time) of a band, not whitened and whitened.

    The real part is the filtered signal, the absolute value its envelope. For whitening, each line of the spectrum is
    divided by the rms amplitude of the lines around it.

    Parameters
    ----------
    signal : (..., time), equidistant
    share : ends of the band, relative to the sampling rate, up to 0.5
    width : width of the range of lines for the rms amplitude, relative to the sampling rate
    """
    size = signal.shape[-1]
    first, last = (int(np.ceil(end * size - _ROUNDING)) for end in share)
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
