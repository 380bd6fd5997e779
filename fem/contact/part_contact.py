"""Partial contact of a slice, compiled: the reduction of its approach relative to full contact.

The gap of a slice is assumed to be constant on a share p of it and to increase linearly by h over the rest. An elastic
foundation x = C f on it, compressed by d from the least gap, carries C f = p d + (1 - p) d^2 / (2 h). With the approach
x = d - a to the mean gap, a = (1 - p) h / 2, and the load f_a of full contact, C f_a = a (1 + p) / (1 - p),

    x = C f - a r,   r = ((1 - s) / (1 - p))^2,   s^2 = p^2 + (1 - p^2) u,   u = f / f_a       (u < 1, else r = 0)

s is the share of the slice in contact. C f represents the approach in full contact, including a Hertz term. The
complementary energy is reduced by a f_a w, with the integral w of r over u,

    w = 2 (G(s) - G(p)) / ((1 - p)^3 (1 + p)),   G(s) = s^2 / 2 - 2 s^3 / 3 + s^4 / 4

a r decreases with f, so the law remains convex for any a, p and f_a; all three depend only on the position
(`fem.contact.slice_means`).
"""

from __future__ import annotations

import math

from fem.numerics.inner_functions import INLINE, inner


@inner(**INLINE)
def part_of(load, per_whole, even):
    """Share s of the slice in contact, 1 in full contact.

    Parameters
    ----------
    load, per_whole : f, N/m, and 1 / f_a
    even : p
    """
    return math.sqrt(max(even * even + (1.0 - even * even) * min(load * per_whole, 1.0), 1e-300))


@inner(**INLINE)
def reduction_of(even, s):
    """Reduction r (even: p)."""
    open_part = (1.0 - s) / (1.0 - even)
    return open_part * open_part


@inner(**INLINE)
def reduction_of_compliance(even, s):
    """Derivative -dr/du."""
    return (1.0 - s) * (1.0 + even) / ((1.0 - even) * s)


@inner(**INLINE)
def reduction_of_work(even, s):
    """Integral w."""
    rest = 1.0 - even
    return 2.0 * (_work(s) - _work(even)) / (rest * rest * rest * (1.0 + even))


@inner(**INLINE)
def _work(s):
    """Function G."""
    return s * s * (0.5 - s * (2.0 / 3.0 - 0.25 * s))


@inner(**INLINE)
def touch(x, rise, even):
    """Approach, m, >= 0, of a slice in full contact with the load of this slice at x, without a Hertz term.

    Parameters
    ----------
    x : approach to the mean gap, m
    rise, even : a, m, and p
    """
    rest = 1.0 - even
    more = 0.5 * rest * rest * max(x + rise, 0.0) / (rise + 1e-300)  # s - p
    return rise * more * (2.0 * even + more) / (rest * rest) if even + more < 1.0 else max(x, 0.0)
