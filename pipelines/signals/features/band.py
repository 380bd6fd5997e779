"""A band of a signal with its spectrum whitened, and the squared envelope of that.

Impacts have wide spectra. Resonances, and lines that other components cause, hide them: whitening gives every part of
the band the same power, so that impacts stand out where the rest is low. Sawalhi & Randall (2005), COMADEM 2005, and
Borghesani, Pennacchi, Randall, Sawalhi & Ricci (2013), Mech. Syst. Signal Process. 36(2), 370-384, do so for bearings.
"""

from __future__ import annotations

import numpy as np

_LEAST = 1e-20  # of the mean power: a part of the band without power stays without


def whitened(signal: np.ndarray, share: tuple[float, float], width: float) -> np.ndarray:
    """Complex signal (..., time) of a band, divided by its root mean square amplitude over a width around each line.

    The real part is the whitened signal, the absolute value its envelope.

    Parameters
    ----------
    signal : (..., time), at even steps of any kind
    share : ends of the band as shares of the sampling rate, up to 0.5
    width : the same, of what is averaged
    """
    size = signal.shape[-1]
    first, last = (int(np.ceil(end * size)) for end in share)
    lines = np.fft.rfft(signal, axis=-1)[..., first:last]
    reach = max(int(0.5 * width * size), 1)
    total = np.cumsum(np.abs(lines) ** 2, axis=-1)
    total = np.concatenate([np.zeros_like(total[..., :1]), total], axis=-1)
    at = np.arange(last - first)
    low, high = np.maximum(at - reach, 0), np.minimum(at + reach + 1, last - first)
    power = (total[..., high] - total[..., low]) / (high - low)
    least = _LEAST * total[..., -1:] + np.finfo(float).tiny
    laid = np.zeros(signal.shape, dtype=complex)
    laid[..., first:last] = 2.0 * lines / np.sqrt(np.maximum(power, least))
    return np.fft.ifft(laid, axis=-1)
