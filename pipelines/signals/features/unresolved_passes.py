"""Bearing parts that a window cannot show, and why: the reasons of a diagnosis, and of a warning before the run."""

from __future__ import annotations

import math

import numpy as np

from pipelines.signals.features.passing import BEYOND, PASS_HARMONICS, SHORT, obstacle, resolved
from pipelines.signals.orders.kinematics import Kinematics

_LONGER = 1.02  # ratio of the windows that are tried
_LONGEST = 250  # number of them: up to 140 times the window


def unresolved_passes(
    kinematics: Kinematics, frequency: float, seconds: float, rate: float, error: float = 0.0
) -> dict[str, str]:
    """Bearing parts whose pass order is not resolved, with the reason and the window that is needed.

    Parameters
    ----------
    kinematics : of the machine
    frequency : mean speed of the first shaft, Hz
    seconds : length of the window
    rate : samples per second
    error : standard uncertainty of the speed, relative
    """
    found = {}
    shafts = [frequency * shaft.ratio for shaft in kinematics.shafts]  # Hz; orders and turns are then Hz and s
    for bearing in kinematics.bearings:
        turn = frequency * kinematics.shaft(bearing.shaft).ratio
        whole = max(math.floor(seconds * turn) - 1.0, 0.5) / turn  # turns from mark to mark that it surely has
        for part, order in bearing.strikes.items():
            line, others = order * turn, (rate / 2, shafts, error)
            if not resolved(line, whole, *others):
                lengths = whole * _LONGER ** np.arange(_LONGEST)
                failing = max(length for length in lengths.tolist() if not resolved(line, length, *others))
                reason = _reason(kinematics, line, failing, *others)
                needed = (
                    f"{failing * _LONGER + 2.0 / turn:.2g} s are" if failing < lengths[-1] else "no longer window is"
                )
                found[part] = f"{reason}; the window has {seconds:.3g} s, {needed} enough"
    return found


def _reason(
    kinematics: Kinematics, line: float, seconds: float, highest: float, shafts: list[float], error: float
) -> str:
    obstacles = [obstacle(n * line, seconds, highest, shafts, error) for n in range(1, PASS_HARMONICS + 1)]
    number, cause = next((n, one) for n, one in enumerate(obstacles, 1) if one is not None)
    its = f"its pass frequency ({line:.5g} Hz)"
    if isinstance(cause, str):
        return {BEYOND: f"multiples of {its} exceed half of the sampling rate", SHORT: f"{its} has too few periods"}[
            cause
        ]
    times = round(number * line / shafts[cause])
    multiple = f"{times} x {kinematics.shafts[cause].name} ({times * shafts[cause]:.5g} Hz)"
    return f"{'' if number == 1 else f'{number} x '}{its} is not separated from {multiple}"
