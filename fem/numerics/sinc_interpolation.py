"""Values of an evenly sampled signal between its samples, band-limited: a sinc under a Kaiser window.

With the cut-off c, a share of half the sampling rate, the error is below 1e-5 of the signal up to 0.9 c, and what lies
above 1.1 c is suppressed below 1e-5: with c below 1 the same sum is the low-pass filter that resampling to a lower
rate needs.

References
----------
Smith & Gossett (1984), A flexible sampling-rate conversion method, Proc. IEEE ICASSP, 19.4.1-19.4.4 (table of the
windowed sinc, cut-off below the rate); Kaiser (1974), Proc. IEEE Int. Symp. Circuits and Systems, 20-23 (window).
"""

from __future__ import annotations

import functools
import math

import numpy as np

HALF_WIDTH = 48  # zeros of the sinc on either side that enter a value
_SHAPE = 12.0  # of the Kaiser window: side lobes 118 dB down
_PER_ZERO = 1000.0  # points of the table between two zeros, read linearly: error below 5e-7
_AT_ONCE = 8192  # positions; so many lie close together in time


def interpolated(values: np.ndarray, position: np.ndarray, cutoff: np.ndarray | float = 1.0) -> np.ndarray:
    """Values (..., position) of signals (..., sample) at positions (m,) between samples, in any order.

    Beyond its ends a signal goes on as its last value: within HALF_WIDTH / cutoff samples of them the error is larger.

    Parameters
    ----------
    values : float (..., n)
    position : float (m,), in samples from the first one
    cutoff : a share of half the sampling rate, above 0 and at most 1, of all positions or of each (m,)
    """
    from fem.numerics.weighted_samples import weighted_samples

    cutoff = np.ascontiguousarray(np.broadcast_to(cutoff, position.shape), dtype=float)
    signals = values.reshape(-1, values.shape[-1])
    out = np.empty((len(signals), len(position)))
    for first in range(0, len(position), _AT_ONCE):
        block = slice(first, first + _AT_ONCE)
        at, reach = position[block], math.ceil(HALF_WIDTH / cutoff[block].min())
        last = signals.shape[1] - 1
        low = int(np.clip(np.floor(at.min()) - reach, 0, last))
        high = int(np.clip(np.ceil(at.max()) + reach, 0, last))
        near = np.ascontiguousarray(signals[:, low : high + 1], dtype=float)
        out[:, block] = weighted_samples(near, at - low, cutoff[block], _table(), _PER_ZERO, HALF_WIDTH)
    return out.reshape(*values.shape[:-1], len(position))


@functools.cache
def _table() -> np.ndarray:
    """The windowed sinc from its middle on, then a zero."""
    place = np.arange(HALF_WIDTH * int(_PER_ZERO) + 2) / _PER_ZERO
    taper = np.i0(_SHAPE * np.sqrt(np.clip(1.0 - (place / HALF_WIDTH) ** 2, 0.0, None))) / np.i0(_SHAPE)
    return np.sinc(place) * taper
