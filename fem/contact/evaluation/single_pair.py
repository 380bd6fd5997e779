"""Line load of one tooth pair without neighbours: C f + A f (B - ln f) = x, compiled.

C tooth and body compliance, A and B the Hertz line contact, f line load (N/m), x approach (m). Above ln f = B - 1 the
Hertz approach is held constant, so x(f) rises for every f > 0 and is concave.
"""

from __future__ import annotations

import math

from numba import njit

from fem.numerics.compiled import PLAIN

CLOSE = 1e-6  # a Newton step this small (relative) leaves an error of about its square times 0.1


@njit(**PLAIN)
def contact_approach(f: float, log: float, slope: float, offset: float) -> tuple[float, float]:
    """Hertz approach A f (B - ln f) and its derivative, held constant above ln f = B - 1."""
    depth = offset - log
    if depth > 1.0:
        return slope * f * depth, slope * (depth - 1.0)
    return slope * math.exp(offset - 1.0), 0.0


@njit(**PLAIN)
def contact_energy(f: float, log: float, slope: float, offset: float) -> tuple[float, float]:
    """Complementary energy of the Hertz approach and its derivative by B."""
    depth = offset - log
    if depth > 1.0:
        return slope * f * f * (0.5 * depth + 0.25), 0.5 * slope * f * f
    top = math.exp(offset - 1.0)
    return slope * top * (f - 0.25 * top), slope * top * (f - 0.5 * top)


@njit(**PLAIN)
def secant_compliance(x: float, compliance: float, slope: float, offset: float) -> float:
    """Secant compliance C + A (B - ln f) of one pair, within a few per cent (one logarithm at x / C)."""
    secant = compliance + slope * max(1.0, offset - math.log(x / compliance))
    ratio = secant / compliance
    return secant + 2.0 * slope * (ratio - 1.0) / (ratio + 1.0)


@njit(**PLAIN)
def moved_log(log: float, f: float, step: float) -> float:
    """ln f after f grew by the part `step`; the series is exact to rounding below 1e-3."""
    if abs(step) < 1e-3:
        return log + step * (1.0 - step * (0.5 - step * (1.0 / 3.0 - 0.25 * step)))
    return math.log(f)


@njit(**PLAIN)
def single_load(x: float, compliance: float, slope: float, offset: float) -> tuple[float, float]:
    """Line load f of one pair without neighbours, C f + A f (B - ln f) = x > 0, and ln f (0 when A = 0)."""
    if slope == 0.0:
        return x / compliance, 0.0
    f = x / secant_compliance(x, compliance, slope, offset)
    log = math.log(f)
    for _ in range(60):
        approach, rate = contact_approach(f, log, slope, offset)
        step = (x - compliance * f - approach) / ((compliance + rate) * f)
        if abs(step) <= CLOSE:
            return f * (1.0 + step), log + step
        step = max(step, -0.9)
        f *= 1.0 + step
        log = moved_log(log, f, step)
    return f, log
