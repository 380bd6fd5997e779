"""A slice that is in contact on a part of its width, compiled: what it approaches by less than when wholly in contact.

Where the gap rises evenly over a slice from its mean less a to its mean plus a, an elastic foundation x = C f carries,
on average over the slice, f_a ((x + a) / 2a)^2 with f_a = a / C, for -a < x < a of the approach x to the mean gap.
Hence with u = f / f_a,

    x = C f - a (1 - sqrt(u))^2        (u < 1, else x = C f)

A gap that is curved, too, has a below its mean and more or less than that above it. The same with this a and with the
load f_a that closes what is above the mean is exact in the curvature to first order. A Hertz term, x = f (C + A (B -
ln f)), makes x / f fall with u^(-2e), e = A f_a / (2 a): with sqrt(u) (1 - e ln u) for sqrt(u) both branches still meet
with the same slope. Altogether x is less by

    a r,   r = (1 - s)^2 + 2 e s (1 - s) ln u,   s = sqrt(u)

and the complementary energy by a f_a w, the integral of r over u,

    w = s^2 + s^4 / 2 - 4/3 s^3 + e (4/3 s^3 (ln u - 2/3) - s^4 (ln u - 1/2))

a r falls with f, so the law stays convex whatever a and f_a are; both depend on the position alone
(`fem.contact.slice_means`).
"""

from __future__ import annotations

import math

from fem.numerics.compiled import INLINE, inner


@inner(**INLINE)
def root_and_log(load, per_whole, log, log_whole):
    """s and ln u at a line load f and its logarithm; 1 and 0 where the slice is wholly in contact.

    Parameters
    ----------
    load, log : f, N/m, and its logarithm
    per_whole, log_whole : 1 / f_a and ln f_a
    """
    return math.sqrt(max(min(load * per_whole, 1.0), 1e-300)), min(log - log_whole, 0.0)


@inner(**INLINE)
def spared(bend, s, log):
    """r, from s and ln u (bend: e)."""
    return (1.0 - s) * (1.0 - s + 2.0 * bend * s * log)


@inner(**INLINE)
def spared_compliance(bend, s, log):
    """-dr/du."""
    return (1.0 - s) * (1.0 - 2.0 * bend) / s - bend * (1.0 / s - 2.0) * log


@inner(**INLINE)
def spared_work(bend, s, log):
    """w: the integral of r over u."""
    cube = 4.0 / 3.0 * s * s * s
    square = s * s
    return square + square * square * (0.5 - bend * (log - 0.5)) - cube * (1.0 - bend * (log - 2.0 / 3.0))


@inner(**INLINE)
def closing_approach(compliance, slope, offset, per_whole, log_whole):
    """Approach, m, at which a slice is just wholly in contact.

    Parameters
    ----------
    compliance, slope, offset : C and A in m2/N, and B
    per_whole, log_whole : 1 / f_a in m/N, and ln f_a
    """
    return (compliance + slope * max(1.0, offset - log_whole)) / per_whole


@inner(**INLINE)
def touch(x, rise, closing):
    """Approach, m, >= 0, at which a slice wholly in contact carries about what this one carries at x.

    Parameters
    ----------
    x : approach to the mean gap, m
    rise, closing : a and `closing_approach`, m
    """
    own = max(x + rise, 0.0)
    root = own / (rise + math.sqrt(max(rise * rise + (closing - rise) * own, 0.0)) + 1e-300)
    return closing * root * root if x < closing else max(x, 0.0)
