"""phi_0(z) = e^z and phi_k(z) = int_0^1 e^((1 - s) z) s^(k-1)/(k-1)! ds: exact motion under polynomial forces.

References
----------
Hochbruck & Ostermann (2010), Acta Numerica 19, 209-286, section 2.1.
"""

from __future__ import annotations

import math

import numpy as np

SERIES_BELOW = 1.0
SERIES_TERMS = 24


def phi_functions(z: np.ndarray, highest: int) -> np.ndarray:
    """phi_0 .. phi_highest (k, z), complex; by their series near 0, where phi_(k+1) = (phi_k - 1/k!)/z cancels."""
    small = abs(z) < SERIES_BELOW
    near, far = np.where(small, z, 0.0), np.where(small, 1.0, z)
    series = np.zeros((highest + 1, *np.shape(z)), dtype=complex)
    closed = np.empty_like(series)
    closed[0] = np.exp(far)
    for k in range(highest + 1):
        for j in range(SERIES_TERMS, -1, -1):
            series[k] = 1.0 / math.factorial(j + k) + near * series[k]
        if k < highest:
            closed[k + 1] = (closed[k] - 1.0 / math.factorial(k)) / far
    return np.where(small, series, closed)
