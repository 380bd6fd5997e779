"""Statistics of the deviation of a recording from healthy ones: standardised deviations and their probabilities.

Let m be the mean of n healthy levels (dB) and s their standard deviation. The deviation of a new level x is

    t = (x - m) / (s~ sqrt(1 + 1/n)),   s~^2 = (d0 s0^2 + d s^2) / (d0 + d),   d = n - 1.

s0 is the common standard deviation of all levels of one kind. Its weight d0 is the larger, the less the standard
deviations of a kind differ (Smyth 2004). Channels of one machine are not independent, so d0 is at most d.
The false-alarm rates are in `pipelines.diagnosis.verdict`.

Levels depend on load and speed, and the load changes the speed of a motor. If a linear regression over the speed
predicts the levels of omitted recordings better than their mean does, the levels are predicted for the speed of the new
recording.

Probabilities come from simulated healthy machines. Levels of real machines have heavier tails than a normal
distribution, so the simulated levels have Student's distribution with TAILS degrees of freedom. A mean over several
features has lighter tails; the estimator of Asmussen & Kroese (2006) gives them.

References
----------
Smyth (2004), Stat. Appl. Genet. Mol. Biol. 3(1), 3 (moderated scales); Allen (1974), Technometrics 16(1), 125-127
(errors of prediction); Asmussen & Kroese (2006), Adv. Appl. Probab. 38(2), 545-558 (tails of sums); Clopper & Pearson
(1934), Biometrika 26(4), 404-413.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache

import numpy as np

FEWEST_FOR_P = 5  # recordings; with fewer the standard deviation is too uncertain
FEWEST_FOR_TREND = FEWEST_FOR_P + 1  # recordings; the slope takes one degree of freedom
SPEED_ERROR = 1e-4  # relative: smaller differences of the speed are not measured
BEYOND = 0.5  # of the range of their speeds, distance outside it up to which levels are extrapolated
LEAST_SPREAD = 0.25  # dB (3 %); simulated levels may scatter less, those of a sensor that is mounted again hardly do
TAILS = 5.0  # degrees of freedom of healthy levels
_UNIT = math.sqrt(TAILS / (TAILS - 2.0))  # standard deviation of Student's distribution with TAILS
_ROUNDING = 1e-9
_BASELINES = 4000  # simulated baselines
_GRID = np.concatenate([np.linspace(-10.0, 20.0, 121), np.geomspace(20.5, 1000.0, 60)])  # standard deviations


def moderated(healthy: np.ndarray, kinds: Sequence[str], least: float) -> tuple[np.ndarray, int]:
    """Standard deviations s~ (channel, line) of healthy levels (recording, channel, line), and d0 as an integer.

    Parameters
    ----------
    healthy : levels of FEWEST_FOR_P recordings or more
    kinds : (line,), lines of one kind have a common s0
    least : lower bound of the standard deviations
    """
    from scipy.special import digamma

    freedom = len(healthy) - 1
    variance = np.maximum(healthy.var(axis=0, ddof=1), least**2)
    logarithm = np.log(variance)
    common = np.empty_like(logarithm)
    names = np.asarray(kinds)
    for kind in set(kinds):
        common[:, names == kind] = np.median(logarithm[:, names == kind])
    mean, scatter, expected = _sampling(len(healthy))
    excess = float(np.mean((logarithm - common) ** 2)) - scatter
    prior = max(int(np.sum(expected >= excess)), 1)
    pooled = np.exp(common + digamma(prior / 2) - math.log(prior / 2) - mean)
    return np.sqrt((prior * pooled + freedom * variance) / (prior + freedom)), prior


def at_speed(healthy: np.ndarray, speeds: np.ndarray, speed: float) -> np.ndarray:
    """Healthy levels, predicted for a speed if they depend on it; otherwise unchanged.

    The mean of the predicted levels is the regression line at the speed. Their standard deviation is that of the
    residuals, which have n - 2 degrees of freedom. It is increased such that the deviation of a new level from the mean
    contains the uncertainty of the line at this speed.

    Parameters
    ----------
    healthy : levels (recording, channel, line)
    speeds : of the recordings (recording,), in the unit of `speed`
    speed : of the recording that is compared with them

    Returns
    -------
    levels (recording, channel, line), for one recording less if they depend on the speed
    """
    from scipy.linalg import null_space

    count, mean = len(healthy), speeds.mean()
    away, reach = speeds - mean, BEYOND * np.ptp(speeds)
    inside = speeds.min() - reach <= speed <= speeds.max() + reach
    if count < FEWEST_FOR_TREND or not inside or np.ptp(speeds) <= SPEED_ERROR * mean:
        return healthy
    share = 1.0 / count + away**2 / (away @ away)  # leverage of each recording
    if share.max() > 1.0 - _ROUNDING:
        return healthy
    centred = healthy - healthy.mean(axis=0)
    slope = np.tensordot(away, centred, axes=1) / (away @ away)
    rest = centred - away[:, None, None] * slope
    of_line = np.sum((rest / (1.0 - share)[:, None, None]) ** 2, axis=0)
    of_mean = np.sum((centred / (1.0 - 1.0 / count)) ** 2, axis=0)
    if 2 * int((of_line < of_mean).sum()) <= int((of_mean > 0.0).sum()):
        return healthy
    wider = (1.0 + 1.0 / count + (speed - mean) ** 2 / (away @ away)) / (1.0 + 1.0 / (count - 1))
    free = null_space(np.stack([np.ones(count), away / np.abs(away).max()])).T @ rest.reshape(count, -1)
    turned = math.sqrt(wider) * null_space(np.ones((1, count - 1))) @ free
    return np.asarray(healthy.mean(axis=0) + (speed - mean) * slope + turned.reshape(-1, *healthy.shape[1:]))


def deviations(levels: np.ndarray, healthy: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Standardised deviations t (channel, line) of levels from healthy ones (recording, channel, line).

    Parameters
    ----------
    levels, healthy : dB, or in another unit
    spread : standard deviations (channel, line) of healthy levels in this unit
    """
    return np.asarray((levels - healthy.mean(axis=0)) / (spread * math.sqrt(1.0 + 1.0 / len(healthy))))


def probability(deviation: np.ndarray, count: int, prior: int, parts: int = 1) -> np.ndarray:
    """Probability, for each single deviation, that a healthy machine has at least this standardised deviation.

    Parameters
    ----------
    deviation : standardised deviations
    count : number of healthy recordings
    prior : d0
    parts : number of features whose mean deviates
    """
    return np.exp(np.interp(deviation, _GRID, _tail(count, prior, parts)))


def limit(chance: float, count: int, prior: int, parts: int = 1) -> float:
    """The standardised deviation that a healthy machine exceeds with a given probability.

    Parameters
    ----------
    chance : probability
    count, prior, parts : as in `probability`
    """
    return float(np.interp(-math.log(chance), -_tail(count, prior, parts), _GRID))


@cache
def _simulated(count: int, parts: int) -> tuple[np.ndarray, np.ndarray]:
    """Means and standard deviations (baseline,) of simulated levels of unit variance, each a mean over `parts`."""
    levels = np.random.default_rng([count, parts]).standard_t(TAILS, (_BASELINES, count, parts)).sum(axis=2)
    levels /= _UNIT * math.sqrt(parts)
    return levels.mean(axis=1), levels.std(axis=1, ddof=1)


@cache
def _sampling(count: int) -> tuple[float, float, np.ndarray]:
    """Mean and variance of the logarithm of a simulated variance, and its excess variances with d0 = 1, 2, ..."""
    from scipy.special import polygamma

    _, spread = _simulated(count, 1)
    sampled = 2.0 * np.log(spread)
    return float(np.mean(sampled)), float(np.var(sampled)), polygamma(1, np.arange(1, count) / 2)


@cache
def _tail(count: int, prior: int, parts: int) -> np.ndarray:
    """Logarithm of the exceedance probability at each deviation of the grid, averaged over simulated baselines."""
    from scipy.special import stdtr

    mean, spread = _simulated(count, parts)
    random, freedom = np.random.default_rng([count, parts, 1]), count - 1
    scale = np.sqrt(prior / random.chisquare(prior, _BASELINES))  # of these levels, with s0 = 1
    used = np.sqrt((prior + freedom * (scale * spread) ** 2) / (prior + freedom)) / scale
    others = random.standard_t(TAILS, (_BASELINES, parts - 1))
    largest, total = others.max(axis=1, initial=-np.inf), others.sum(axis=1)
    factor = math.sqrt(1.0 + 1.0 / count)
    found = []
    for deviation in _GRID:
        place = _UNIT * math.sqrt(parts) * (mean + deviation * factor * used)
        found.append(parts * np.mean(stdtr(TAILS, -np.maximum(largest, place - total))))
    return np.minimum.accumulate(np.log(np.clip(found, 1e-300, 1.0)))


def clopper_pearson(count: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Confidence interval of the probability of an event that occurred `count` times in `trials`, which may be 0."""
    from scipy.stats import beta

    outside = (1.0 - confidence) / 2.0
    low = 0.0 if count == 0 else float(beta.ppf(outside, count, trials - count + 1))
    high = 1.0 if count == trials else float(beta.isf(outside, count + 1, trials - count))
    return low, high
