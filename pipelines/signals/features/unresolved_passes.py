"""Bearing parts that a window cannot show, and why: the reasons of a diagnosis, and of a warning before the run."""

from __future__ import annotations

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
        whole = max(seconds - 1.0 / turn, 0.5 / turn)  # the window may begin at any angle
        for part, order in bearing.strikes.items():
            known = turn * order, rate / 2, shafts, error
            if not resolved(known[0], whole, *known[1:]):
                needed = None
                for length in (whole * _LONGER**n for n in range(_LONGEST, -1, -1)):
                    if not resolved(known[0], length, *known[1:]):
                        break
                    needed = length + 1.0 / turn
                found[part] = _reason(kinematics, seconds, length, needed, *known)
    return found


def _reason(
    kinematics: Kinematics,
    seconds: float,
    failing: float,
    needed: float | None,
    line: float,
    highest: float,
    shafts: list[float],
    error: float,
) -> str:
    obstacles = [obstacle(n * line, failing, highest, shafts, error) for n in range(1, PASS_HARMONICS + 1)]
    number, cause = next((n, one) for n, one in enumerate(obstacles, 1) if one is not None)
    if cause == BEYOND:
        return f"multiples of its pass frequency ({line:.4g} Hz) are above half of the sampling rate"
    if cause == SHORT:
        reason = f"its pass frequency ({line:.4g} Hz) has too few periods in a window of {seconds:.3g} s"
    else:
        shaft, turn = kinematics.shafts[int(cause)].name, shafts[int(cause)]
        times = round(number * line / turn)
        reason = (
            f"{'' if number == 1 else f'{number} x '}its pass frequency ({number * line:.5g} Hz) is not separated from "
            f"{times} x {shaft} ({times * turn:.5g} Hz) in a window of {seconds:.3g} s"
        )
    return f"{reason}; {'no longer window suffices' if needed is None else f'{needed:.2g} s are needed'}"
