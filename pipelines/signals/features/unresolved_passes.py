"""Bearing parts that a window cannot show, and why: the reasons of a diagnosis, and of a warning before the run."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipelines.signals.orders.kinematics import Kinematics

PASS_HARMONICS = 3
FEWEST = 2 / 3  # share of the lines within the spectrum and not at a multiple of a shaft speed
SCATTER = 0.001  # of a line, to either side, for slip that is not constant
FLOOR = 0.1  # of a pass order, to either side: range of the floor
FEWEST_LINES = 8  # of the spectrum in the floor, or between multiples of a shaft speed
BEYOND, SHORT = "beyond", "short"  # obstacles: the end of the spectrum, too few lines in the floor
_LOBE = 2.0  # half width in lines of an order with a Hann window
COMB = 4.0  # lines: multiples that are closer do not show as single lines
_MANY = 5  # times FEWEST_LINES to either side: multiples of shafts leave enough lines for a floor
_SEEN = 1.0  # lines from the middle of an order, where it is 6 dB lower: near enough to a line that is not omitted
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
    repeats = [frequency * order for order in kinematics.tooth_repeats().values()]
    others = (rate / 2, [*shafts, *repeats], error)

    def shown(line: float, length: float) -> bool:
        return not crowded(repeats, length) and resolved(line, length, *others)

    for bearing in kinematics.bearings:
        turn = frequency * kinematics.shaft(bearing.shaft).ratio
        whole = max(math.floor(seconds * turn) - 1.0, 0.5) / turn  # turns from mark to mark that it surely has
        for part, order in bearing.strikes.items():
            line = order * turn
            if not shown(line, whole):
                lengths = whole * _LONGER ** np.arange(_LONGEST)
                failing = max(length for length in lengths.tolist() if not shown(line, length))
                reason = _reason(kinematics, line, failing, *others)
                needed = (
                    f"{failing * _LONGER + 2.0 / turn:.2g} s are" if failing < lengths[-1] else "no longer window is"
                )
                found[part] = f"{reason}; the window has {seconds:.3g} s, {needed} enough"
    return found


def _reason(
    kinematics: Kinematics, line: float, seconds: float, highest: float, shafts: list[float], error: float
) -> str:
    its = f"its pass frequency ({line:.5g} Hz)"
    obstacles = [obstacle(n * line, seconds, highest, shafts, error) for n in range(1, PASS_HARMONICS + 1)]
    number, cause = next(((n, one) for n, one in enumerate(obstacles, 1) if one is not None), (1, len(shafts) - 1))
    if isinstance(cause, str):
        return {BEYOND: f"multiples of {its} exceed half of the sampling rate", SHORT: f"{its} has too few periods"}[
            cause
        ]
    if cause >= len(kinematics.shafts):
        return f"{its} is not separated from multiples of {shafts[cause]:.4g} Hz, at which the same teeth meet again"
    times = round(number * line / shafts[cause])
    multiple = f"{times} x {kinematics.shafts[cause].name} ({times * shafts[cause]:.5g} Hz)"
    return f"{'' if number == 1 else f'{number} x '}{its} is not separated from {multiple}"


def crowded(repeats: Sequence[float], turns: float) -> bool:
    """Whether multiples of the orders at which the same teeth meet again leave no lines between them."""
    return any(COMB <= order * turns < FEWEST_LINES for order in repeats)


def resolved(order: float, turns: float, highest: float, shafts: Sequence[float], error: float = 0.0) -> bool:
    """Whether enough multiples of a pass order without slip are visible, that is, have no `obstacle`.

    Parameters
    ----------
    order : pass order
    turns, highest, shafts, error : as in `obstacle`
    """
    obstacles = [obstacle(n * order, turns, highest, shafts, error) for n in range(1, PASS_HARMONICS + 1)]
    return obstacles.count(None) >= FEWEST * PASS_HARMONICS


def obstacle(order: float, turns: float, highest: float, shafts: Sequence[float], error: float) -> str | int | None:
    """Why a spectrum does not show the line of an order: BEYOND, SHORT, or the number (from 0) of a shaft.

    A multiple of the speed of this shaft is too close. None if there is no reason.

    Parameters
    ----------
    order : of the line
    turns : in the window
    highest : order in the spectrum
    shafts : turns of all shafts per turn of this one
    error : standard uncertainty of the speed, relative
    """
    if (1.0 + FLOOR) * order > highest:
        return BEYOND
    around = FLOOR * order * turns
    near = np.arange(max(int(order * turns - around), 0), int(order * turns + around) + 1)
    few = (
        around < _MANY * FEWEST_LINES
        and free_lines(near, [turns * step for step in shafts], error).sum() < FEWEST_LINES
    )
    if around < FEWEST_LINES / 2 or few:
        return SHORT
    close = (_LOBE - _SEEN) / turns + min(error, SCATTER) * order
    steps = [step if step * turns >= FEWEST_LINES else math.inf for step in shafts]
    return next((n for n, step in enumerate(steps) if abs(math.remainder(order, step)) <= close), None)


def free_lines(place: np.ndarray, steps: Sequence[float], error: float) -> np.ndarray:
    """Whether lines (place,) are away from the multiples of shafts, whose distances `steps` are in lines."""
    free = np.ones(len(place), dtype=bool)
    for step in (one for one in steps if one >= FEWEST_LINES):
        free &= np.abs(place - step * np.round(place / step)) > _LOBE + min(error, SCATTER) * place
    return free
