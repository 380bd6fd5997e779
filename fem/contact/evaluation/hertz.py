"""Line contact of one tooth pair, compiled: C f + A f (B - ln f) = x.

C tooth and body compliance, A and B the Hertz line contact, f line load (N/m), x approach (m). The Hertz term stops
growing at ln f = B - 1, where the contact is as wide as the depth that B counts to; above it is held constant, so that
x(f) rises for every f > 0 and is concave. With D = B - ln f and t = min(1, exp(D - 1)), t < 1 beyond that range,

    approach            A f (max(D, 1) + t - 1)
    its derivative      A max(D - 1, 0)
    compl. energy       A f^2 (max(D, 1)/2 + 1/4 + (t - t^2/4 - 3/4))
    its derivative by B A f^2 (1/2 + (t - t^2/2 - 1/2))
"""

from __future__ import annotations

import math

from fem.contact.part_contact import part_of, spared, spared_compliance, touch
from fem.numerics.compiled import INLINE, inner

CLOSE = 1e-8  # a Newton step this small (relative) leaves an error of about its square times 0.1


@inner(**INLINE)
def hertz_depth(depth, beyond):
    """The Hertz approach over A f: `depth` is D, `beyond` is t."""
    return max(depth, 1.0) + beyond - 1.0


@inner(**INLINE)
def compliance_of(compliance, slope, depth):
    """dx/df of one pair."""
    return compliance + slope * max(depth - 1.0, 0.0)


@inner(**INLINE)
def secant_compliance(compliance, slope, depth):
    """x / f of one pair within a few per cent, from the depth D at the load x / C."""
    secant = compliance + slope * max(1.0, depth)
    return secant + 2.0 * slope * (secant - compliance) / (secant + compliance)


@inner()
def single_load(x, compliance, slope, offset, part):
    """Line load f (N/m) of one pair in a slice, and ln f.

    Parameters
    ----------
    x : approach to the mean gap of the slice, m, > -rise
    compliance, slope, offset : C > 0 and A >= 0 in m2/N, and B
    part : rise a, 1 / f_a and p of `fem.contact.part_contact`
    """
    rise, per_whole, even = part
    whole = touch(x, rise, even)
    f = whole / secant_compliance(compliance, slope, offset - math.log(whole / compliance))
    log = math.log(f)
    for _ in range(60):
        depth = offset - log
        s = part_of(f, per_whole, even)
        rest = x + rise * spared(even, s) - f * (compliance + slope * hertz_depth(depth, exceeded(depth)))
        stiff = compliance_of(compliance, slope, depth) + rise * per_whole * spared_compliance(even, s)
        step = rest / (stiff * f)
        if abs(step) <= CLOSE:
            return f * (1.0 + step), log + step
        f *= 1.0 + max(step, -0.9)
        log = math.log(f)
    return f, log


@inner(**INLINE)
def exceeded(depth):
    """t: 1 within the range of the Hertz term."""
    return math.exp(depth - 1.0) if depth < 1.0 else 1.0
