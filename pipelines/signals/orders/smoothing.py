"""A smooth curve through equidistant, noisy values, and the standard uncertainty of its total increase.

The curve x minimises sum (y - x)^2 + strength * sum (third difference of x)^2. For a large strength it is a parabola.
It is the posterior mean if the curvature is a random walk and the noise is white. The strength is the one of maximum
likelihood. Before the first and after the last value the curve is a parabola.

References
----------
Whittaker (1923), Proc. Edinburgh Math. Soc. 41, 63-75 (the sum); Wahba (1985), Ann. Stat. 13(4), 1378-1402 (strength of
the greatest likelihood); Wahba (1983), J. R. Stat. Soc. B 45(1), 133-150 (uncertainty from the posterior of the curve).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

STRENGTHS = np.logspace(-2, 14, 65)


class Smooth(NamedTuple):
    """`values` (n,) of the curve; standard deviations `noise` of a given value and `climb` of the total increase."""

    values: np.ndarray
    noise: float
    climb: float


def smooth(values: np.ndarray, before: int, after: int) -> Smooth:
    """The curve at the values, and continued before and after them.

    Parameters
    ----------
    values : float (n,), at least four
    before, after : numbers of additional points
    """
    from scipy.linalg import solveh_banded

    n = len(values) + before + after
    seen = np.zeros(n)
    seen[before : before + len(values)] = 1.0
    given = np.zeros(n)
    parabola = np.polynomial.Polynomial.fit(np.arange(len(values)), values, 2)  # subtracted to reduce rounding errors
    trend = parabola(np.arange(n) - before)
    given[before : before + len(values)] = values - trend[before : before + len(values)]
    bending = _third_differences(n)
    free = (2.0 - 2.0 * np.cos(np.pi * np.arange(len(values)) / len(values))) ** 3  # eigenvalues of the bending
    kept = len(values) - 3  # the parabola is free
    tried = []
    for strength in STRENGTHS:
        band = strength * bending
        band[-1] += seen
        curve = solveh_banded(band, given)
        variance = (np.sum(seen * (given - curve) ** 2) + strength * np.sum(np.diff(curve, 3) ** 2)) / kept
        unlikely = kept * np.log(max(variance, np.finfo(float).tiny) / strength) + np.log1p(strength * free).sum()
        tried.append((unlikely, variance, band, curve))
    _, variance, band, curve = min(tried, key=lambda one: one[0])
    ends = np.zeros(n)
    ends[0], ends[-1] = -1.0, 1.0
    climb = np.sqrt(variance * (ends @ solveh_banded(band, ends)))
    return Smooth(values=curve + trend, noise=float(np.sqrt(variance)), climb=float(climb))


def _third_differences(n: int) -> np.ndarray:
    """D^T D of the third differences D (n - 3, n), upper bands (4, n)."""
    from scipy.sparse import diags

    differences = diags((-1.0, 3.0, -3.0, 1.0), (0, 1, 2, 3), shape=(n - 3, n))
    product = (differences.T @ differences).tocsr()
    return np.array([np.pad(product.diagonal(above), (above, 0)) for above in (3, 2, 1, 0)])
