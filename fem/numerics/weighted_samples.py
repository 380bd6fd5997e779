"""Sums of samples under a symmetric kernel that is given as a table. Importing this module imports numba."""

from __future__ import annotations

import math

import numpy as np

from fem.numerics.compiled import stored
from fem.numerics.inner_functions import UNCOUNTED


def weighted_samples(
    values: np.ndarray, position: np.ndarray, cutoff: np.ndarray, table: np.ndarray, per_zero: float, half_width: float
) -> np.ndarray:
    """Sums (channel, m) over the samples of `values` (channel, n) about every position, by weights that sum to 1.

    The weight at a distance d is read linearly from the table at d * cutoff * per_zero and is 0 from half_width on;
    a sample before the first or after the last one has their value.

    Parameters
    ----------
    values : (channel, n)
    position : (m,), in samples from the first one
    cutoff : (m,), a share of half the sampling rate
    table : of the weights, from distance 0
    per_zero : points of the table per sample at cutoff 1
    half_width : distance at cutoff 1 where the table ends, in samples
    """
    out = np.empty((len(values), position.size))
    weight = np.empty(2 * math.ceil(half_width / cutoff.min()) + 2)
    _weigh(values, position, cutoff, table, per_zero, half_width, weight, out)
    return out


@stored(__file__, fastmath={"contract", "reassoc"}, **UNCOUNTED)
def _weigh(values, position, cutoff, table, per_zero, half_width, weight, out):
    channels, samples = values.shape
    for i in range(position.size):
        first = math.floor(position[i] - half_width / cutoff[i]) + 1
        last = math.ceil(position[i] + half_width / cutoff[i])
        total = 0.0
        for k in range(last - first):
            place = abs(position[i] - first - k) * cutoff[i] * per_zero
            below = int(place)
            weight[k] = table[below] + (place - below) * (table[below + 1] - table[below])
            total += weight[k]
        inside, start = first >= 0 and last <= samples, np.uint64(max(first, 0))  # unsigned: no index from the end
        for channel in range(channels):
            found = 0.0
            if inside:
                for k in range(np.uint64(last - first)):
                    found += weight[k] * values[channel, start + k]
            else:
                for k in range(last - first):
                    found += weight[k] * values[channel, min(max(first + k, 0), samples - 1)]
            out[channel, i] = found / total
