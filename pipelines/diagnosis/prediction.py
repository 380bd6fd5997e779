"""Is a new recording another of the healthy ones? p-values, their correction for many tests, and rates of alarms.

The model is stated: levels in dB of healthy recordings are draws of one normal distribution. Then a new healthy level x
lies about the mean m of n others with

    t = (x - m) / (s sqrt(1 + 1/n)),   Student's t with n - 1 degrees of freedom,

s their standard deviation, or LEAST_SPREAD if that is more. Ranks, which take no model, cannot give p-values below
1 / (n + 1).

References
----------
Hahn & Meeker (1991), Statistical Intervals, 4.7 (prediction interval of one new observation); Holm (1979), Scand. J.
Statist. 6(2), 65-70; Clopper & Pearson (1934), Biometrika 26(4), 404-413.
"""

from __future__ import annotations

import math

import numpy as np

FEWEST_FOR_P = 5  # recordings; with fewer the standard deviation is hardly known
LEAST_SPREAD = 0.25  # dB, 3 %: levels of a model may repeat better, those of a sensor that is mounted anew hardly do


def p_values(levels: np.ndarray, healthy: np.ndarray) -> np.ndarray:
    """Probability (line,) that a healthy recording has levels as high as these, each line for itself.

    Parameters
    ----------
    levels : (line,), dB
    healthy : (recording, line), dB, of FEWEST_FOR_P recordings or more

    Raises
    ------
    ValueError : fewer recordings
    """
    from scipy.stats import t

    count = len(healthy)
    if count < FEWEST_FOR_P:
        raise ValueError(f"{count} healthy recordings: p-values need {FEWEST_FOR_P} or more")
    spread = np.maximum(healthy.std(axis=0, ddof=1), LEAST_SPREAD)
    standing = (levels - healthy.mean(axis=0)) / (spread * math.sqrt(1.0 + 1.0 / count))
    return np.asarray(t.sf(standing, count - 1))


def holm(p: np.ndarray) -> np.ndarray:
    """p-values (line,) corrected for their number: the chance that any of healthy lines falls below a is at most a."""
    order = np.argsort(p, kind="stable")
    raised = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    out = np.empty_like(p)
    out[order] = np.minimum(raised, 1.0)
    return out


def clopper_pearson(count: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of the probability of something that came `count` times in `trials`, which may be none."""
    from scipy.stats import beta

    outside = (1.0 - confidence) / 2.0
    low = 0.0 if count == 0 else float(beta.ppf(outside, count, trials - count + 1))
    high = 1.0 if count == trials else float(beta.isf(outside, count + 1, trials - count))
    return low, high
