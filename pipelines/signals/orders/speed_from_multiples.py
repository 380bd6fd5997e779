"""A speed that is only roughly known, determined from the multiples of the shafts in the envelope spectrum.

Unbalance, misalignment and gears modulate the vibration once per turn of a shaft and at multiples of it. The score of a
speed is the mean level of these multiples over the floor of the spectrum. All speeds with a score over SHARE of the
highest one remain possible. SHARE was fixed with 800 simulated recordings that also contain other lines. Of the 144
speeds known by it to half of the given uncertainty one was wrong, with 0.5 it was 5 of 222. In 600 others, 0 of 120.

References
----------
Ho & Randall (2000), Mech. Syst. Signal Process. 14(5), 763-788 (spectrum of the squared envelope).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.signals.orders.kinematics import Kinematics
from pipelines.signals.orders.revolutions import HIGHEST
from pipelines.signals.orders.whitening import banded

MULTIPLES = 10  # of each shaft
FEWEST_TURNS = 8  # of a shaft whose multiples count
LEAD = 20.0  # dB, limit of the level of a line, so that all multiples count and not a few strong lines of other causes
SHARE = 0.4  # of the highest score
LEAST = 0.001  # uncertainty, relative: the speed of a machine is never quite constant


def by_multiples(
    signals: Sequence[np.ndarray], angle: np.ndarray, kinematics: Kinematics, uncertainty: float
) -> tuple[float, float]:
    """The speed, relative to the given one, at which the multiples of the shafts are highest, and its uncertainty.

    The uncertainty is the largest relative distance of another possible speed; inf if no multiple can be evaluated.

    Parameters
    ----------
    signals : (time,) of every channel, equidistant
    angle : of the first shaft (time,) in rad, increasing
    kinematics : of the machine
    uncertainty : of the speed, relative, to either side
    """
    turns = float(angle[-1] - angle[0]) / (2.0 * np.pi)
    guard = kinematics.envelope_order * turns / len(angle)  # of the sampling rate
    ratios = {shaft.ratio for shaft in kinematics.shafts if shaft.ratio * turns >= FEWEST_TURNS}
    orders = np.outer(sorted(ratios), np.arange(1, MULTIPLES + 1)).ravel()
    orders = orders[orders * (1.0 + uncertainty) * turns < len(angle) // 2]
    if not guard < HIGHEST or not len(orders) or not signals:
        return 1.0, np.inf
    tried = int(2.0 * uncertainty * turns * orders.max())  # to either side, half a line apart for the highest
    factors = 1.0 + uncertainty * np.linspace(-1.0, 1.0, 2 * tried + 1)
    at = np.rint(turns * orders[:, None] * factors).astype(int)
    even, window = np.linspace(angle[0], angle[-1], len(angle)), np.hanning(len(angle))
    score = np.zeros(len(factors))
    for signal in signals:
        squares = np.abs(banded(signal - signal.mean(), (guard, HIGHEST), guard)[1]) ** 2
        lines = np.abs(np.fft.rfft((np.interp(even, angle, squares) - squares.mean()) * window))
        floor = max(float(np.median(lines[at.min() : at.max() + 1])), np.finfo(float).tiny)
        score += np.minimum(20.0 * np.log10(np.maximum(lines[at] / floor, 1.0)), LEAD).mean(axis=0)
    best = float(factors[score.argmax()])
    return best, float(np.abs(factors[score >= SHARE * score.max()] - best).max())
