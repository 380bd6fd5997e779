"""Is a new recording another of the healthy ones? Standardised deviations, their probabilities, rates of alarms.

With m the mean of n healthy levels (dB) and s their standard deviation, a new level x deviates by

    t = (x - m) / (s~ sqrt(1 + 1/n)),   s~^2 = (d0 s0^2 + d s^2) / (d0 + d),   d = n - 1.

s0 is the scale that all levels of one kind have in common, and d0 its weight (Smyth 2004): the less the scales of a
kind differ, the larger. Channels of one machine are not independent, so d0 is at most d.

Levels depend on load and speed, and the load changes the speed of a motor. Where a line over the speed predicts the
levels of left-out recordings better than their mean does, the levels are taken at the speed of the new recording.

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

FEWEST_FOR_P = 5  # recordings; with fewer the standard deviation is hardly known
FEWEST_FOR_TREND = FEWEST_FOR_P + 1  # recordings: the slope takes the place of one
BEYOND = 0.5  # of the range of their speeds: how far outside it levels follow the line
LEAST_SPREAD = 0.25  # dB, 3 %: levels of a model may repeat better, those of a sensor that is mounted anew hardly do
TAILS = 5.0  # degrees of freedom of healthy levels
_UNIT = math.sqrt(TAILS / (TAILS - 2.0))  # standard deviation of Student's distribution with TAILS
_ROUNDING = 1e-9
_DRAWS = 4000  # simulated baselines
_GRID = np.concatenate([np.linspace(-10.0, 20.0, 121), np.geomspace(20.5, 1000.0, 60)])  # standard deviations


def moderated(healthy: np.ndarray, kinds: Sequence[str], least: float) -> tuple[np.ndarray, int]:
    """Standard deviations s~ (channel, line) of healthy levels (recording, channel, line), and d0 as a whole number.

    Parameters
    ----------
    healthy : levels of FEWEST_FOR_P recordings or more
    kinds : (line,), lines of one kind have one s0
    least : standard deviation, no level repeats better
    """
    from scipy.special import digamma, polygamma

    freedom = len(healthy) - 1
    variance = np.maximum(healthy.var(axis=0, ddof=1), least**2)
    logarithm = np.log(variance)
    common = np.empty_like(logarithm)
    names = np.asarray(kinds)
    for kind in set(kinds):
        common[:, names == kind] = np.median(logarithm[:, names == kind])
    _, spread = _simulated(len(healthy), 1)
    drawn = 2.0 * np.log(spread)
    excess = float(np.mean((logarithm - common) ** 2)) - float(np.var(drawn))
    worth = polygamma(1, np.arange(1, freedom + 1) / 2)  # the excess with d0 = 1, 2, ...
    prior = max(int(np.sum(worth >= excess)), 1)
    pooled = np.exp(common + digamma(prior / 2) - math.log(prior / 2) - np.mean(drawn))
    return np.sqrt((prior * pooled + freedom * variance) / (prior + freedom)), prior


def at_speed(healthy: np.ndarray, speeds: np.ndarray, speed: float) -> np.ndarray:
    """Healthy levels as they would be at a speed, if they depend on it; otherwise as they are.

    Their mean is the line at the speed, their standard deviation that of the residuals, as n - 2 of them are free. It
    is larger by the uncertainty of the line there than by that of a mean.

    Parameters
    ----------
    healthy : levels (recording, channel, line)
    speeds : of the recordings (recording,), in the unit of `speed`
    speed : of the recording that is compared with them

    Returns
    -------
    levels (recording, channel, line), of one recording less if they depend on the speed
    """
    from scipy.linalg import null_space

    count, mean = len(healthy), speeds.mean()
    away, reach = speeds - mean, BEYOND * np.ptp(speeds)
    share = 1.0 / count + away**2 / max(float(away @ away), np.finfo(float).tiny)  # of a recording in its own line
    inside = speeds.min() - reach <= speed <= speeds.max() + reach
    if count < FEWEST_FOR_TREND or not inside or reach == 0.0 or share.max() > 1.0 - _ROUNDING:
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
    """Probability that a healthy machine has a standardised deviation of at least this, each for itself.

    Parameters
    ----------
    deviation : standardised
    count : healthy recordings
    prior : d0
    parts : number of features whose mean it is
    """
    return np.exp(np.interp(deviation, _GRID, _tail(count, prior, parts)))


def limit(chance: float, count: int, prior: int, parts: int = 1) -> float:
    """The standardised deviation that a healthy machine exceeds with a chance.

    Parameters
    ----------
    chance : probability
    count, prior, parts : as in `probability`
    """
    return float(np.interp(-math.log(chance), -_tail(count, prior, parts), _GRID))


@cache
def _simulated(count: int, parts: int) -> tuple[np.ndarray, np.ndarray]:
    """Means and standard deviations (baseline,) of simulated levels: means over `parts` of unit variance together."""
    levels = np.random.default_rng([count, parts]).standard_t(TAILS, (_DRAWS, count, parts)).sum(axis=2)
    levels /= _UNIT * math.sqrt(parts)
    return levels.mean(axis=1), levels.std(axis=1, ddof=1)


@cache
def _tail(count: int, prior: int, parts: int) -> np.ndarray:
    """Logarithm of the probability at every deviation of the grid, the mean over simulated baselines."""
    from scipy.special import stdtr

    mean, spread = _simulated(count, parts)
    random, freedom = np.random.default_rng([count, parts, 1]), count - 1
    scale = np.sqrt(prior / random.chisquare(prior, _DRAWS))  # of these levels, with s0 = 1
    used = np.sqrt((prior + freedom * (scale * spread) ** 2) / (prior + freedom)) / scale
    others = random.standard_t(TAILS, (_DRAWS, parts - 1))
    largest, total = others.max(axis=1, initial=-np.inf), others.sum(axis=1)
    factor = math.sqrt(1.0 + 1.0 / count)
    found = []
    for deviation in _GRID:
        place = _UNIT * math.sqrt(parts) * (mean + deviation * factor * used)
        found.append(parts * np.mean(stdtr(TAILS, -np.maximum(largest, place - total))))
    return np.minimum.accumulate(np.log(np.clip(found, 1e-300, 1.0)))


def clopper_pearson(count: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of the probability of something that came `count` times in `trials`, which may be none."""
    from scipy.stats import beta

    outside = (1.0 - confidence) / 2.0
    low = 0.0 if count == 0 else float(beta.ppf(outside, count, trials - count + 1))
    high = 1.0 if count == trials else float(beta.isf(outside, count + 1, trials - count))
    return low, high
