"""A root of a function in one unknown."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable

_MOST_STEPS = 100


def brentq(function: Callable[[float], float], low: float, high: float, *, xtol: float = 2e-12) -> float:
    """The root between two points where the function has different signs, by Brent's method.

    It takes the steps of `scipy.optimize.brentq` and ends at the same number, to the last bit; importing that package
    takes longer than `gearcase check` without it.

    Parameters
    ----------
    function : of the unknown
    low, high : where the function has different signs
    xtol : error of the root, besides 4 units of its last place

    Raises
    ------
    ValueError : the function has the same sign at both ends, or is not a number there
    RuntimeError : no root after 100 steps

    References
    ----------
    R. P. Brent (1973), Algorithms for Minimization Without Derivatives, ch. 3-4.
    """
    last, x, across = low, high, 0.0  # the point before, the best one, one on the other side of the root
    f_last, f, f_across = float(function(last)), float(function(x)), 0.0
    step_before = step = 0.0
    if f_last == 0.0:
        return last
    if f == 0.0:
        return x
    if (f_last < 0.0) == (f < 0.0) or math.isnan(f_last + f):
        raise ValueError(f"f({low:.6g}) = {f_last:.6g} and f({high:.6g}) = {f:.6g} must have different signs")
    for _ in range(_MOST_STEPS):
        if f_last != 0.0 and f != 0.0 and (f_last < 0.0) != (f < 0.0):
            across, f_across = last, f_last
            step_before = step = x - last
        if abs(f_across) < abs(f):
            last, x, across = x, across, x
            f_last, f, f_across = f, f_across, f
        tolerance = (xtol + 4.0 * sys.float_info.epsilon * abs(x)) / 2.0
        half = (across - x) / 2.0
        if f == 0.0 or abs(half) < tolerance:
            return x
        tried = math.inf
        if abs(step_before) > tolerance and abs(f) < abs(f_last):
            if last == across:  # the secant
                tried = -f * (x - last) / (f - f_last)
            else:  # the inverse parabola
                slope_last, slope_across = (f_last - f) / (last - x), (f_across - f) / (across - x)
                tried = -f * (f_across * slope_across - f_last * slope_last)
                tried /= slope_across * slope_last * (f_across - f_last)
        if 2.0 * abs(tried) < min(abs(step_before), 3.0 * abs(half) - tolerance):
            step_before, step = step, tried
        else:
            step_before = step = half
        last, f_last = x, f
        x += step if abs(step) > tolerance else math.copysign(tolerance, half)
        f = float(function(x))
    raise RuntimeError(f"no root between {low:.6g} and {high:.6g} after {_MOST_STEPS} steps")
