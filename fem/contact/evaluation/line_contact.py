"""Line contact of one tooth pair in one slice, compiled: C f + A f (B - ln f) = x, and the logarithm it needs.

C tooth and body compliance, A and B the Hertz line contact (`fem.contact.wheels.hertz_terms`), f line load (N/m), x
approach (m). The Hertz term stops growing at ln f = B - 1, where the contact is as wide as the depth that B counts to;
above it is held constant, so that x(f) rises for every f > 0 and is concave. With D = B - ln f and
t = min(1, exp(D - 1)), t < 1 beyond that range,

    approach            A f (max(D, 1) + t - 1)
    its derivative      A max(D - 1, 0)
    compl. energy       A f^2 (max(D, 1)/2 + 1/4 + (t - t^2/4 - 3/4))
    its derivative by B A f^2 (1/2 + (t - t^2/2 - 1/2))

Without a vector library the compiler calls the logarithm of the C library number by number, which takes twice as long
as `logarithm` (reduction and series of fdlibm, e_log.c); an evaluation needs two to four times 32 logarithms.
"""

from __future__ import annotations

import math

from fem.contact.part_contact import part_of, reduction_of, reduction_of_compliance, touch
from fem.numerics.inner_functions import INLINE, inner

CLOSE = 1e-8  # a Newton step this small (relative) leaves an error of about its square times 0.1
SERIES = 0.02  # largest change for `log_of_growth`
_LN2 = math.log(2.0)
_BIAS = 4503599627370496.0 + 1023.0
_ONE, _HALF_ROOT = 0x3FF0000000000000, 0x3FE6A09E667F3BCD  # bits of 1 and of sqrt(1/2)
_L1, _L2, _L3, _L4, _L5, _L6, _L7 = (
    6.666666666666735130e-01,
    3.999999999940941908e-01,
    2.857142874366239149e-01,
    2.222219843214978396e-01,
    1.818357216161805012e-01,
    1.531383769920937332e-01,
    1.479819860510658591e-01,
)


@inner(**INLINE)
def hertz_depth(depth, beyond):
    """The Hertz approach over A f: `depth` is D, `beyond` is t."""
    return max(depth, 1.0) + beyond - 1.0


@inner(**INLINE)
def compliance_of(compliance, slope, depth):
    """dx/df of one pair."""
    return compliance + slope * max(depth - 1.0, 0.0)


@inner(**INLINE)
def hertz_validity(depth):
    """t: 1 within the range of the Hertz term."""
    return math.exp(depth - 1.0) if depth < 1.0 else 1.0


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
    secant = compliance + slope * max(1.0, offset - math.log(whole / compliance))
    f = whole / (secant + 2.0 * slope * (secant - compliance) / (secant + compliance))
    log = math.log(f)
    for _ in range(60):
        depth = offset - log
        s = part_of(f, per_whole, even)
        rest = x + rise * reduction_of(even, s) - f * (compliance + slope * hertz_depth(depth, hertz_validity(depth)))
        stiff = compliance_of(compliance, slope, depth) + rise * per_whole * reduction_of_compliance(even, s)
        step = rest / (stiff * f)
        if abs(step) <= CLOSE:
            return f * (1.0 + step), log + step
        f *= 1.0 + max(step, -0.9)
        log = math.log(f)
    return f, log


@inner(**INLINE)
def logarithm(values, bits, numbers, logs, scratch):
    """ln of row `numbers` into row `logs`, to rounding.

    Parameters
    ----------
    values : (row, lane); row `numbers` holds normal positive numbers, row `scratch` is overwritten
    bits : the same memory as int64
    numbers, logs, scratch : numbers of rows
    """
    for s in range(values.shape[1]):
        k = bits[numbers, s] + (_ONE - _HALF_ROOT)
        bits[scratch, s] = (k & 0xFFFFFFFFFFFFF) + _HALF_ROOT
        bits[logs, s] = (k >> 52) | 0x4330000000000000
        f = values[scratch, s] - 1.0
        q = f / (2.0 + f)
        z = q * q
        r = z * (_L1 + z * (_L2 + z * (_L3 + z * (_L4 + z * (_L5 + z * (_L6 + z * _L7))))))
        values[logs, s] = (values[logs, s] - _BIAS) * _LN2 + (f - (0.5 * f * f - q * (0.5 * f * f + r)))


@inner(**INLINE)
def rough_log(bits):
    """ln of a number from its bits, within 0.03."""
    return (bits * 2.0**-52 - 1022.957) * _LN2


@inner(**INLINE)
def log_of_growth(t):
    """ln(1 + t), to rounding up to |t| = SERIES."""
    return t * (1 - t * (1 / 2 - t * (1 / 3 - t * (1 / 4 - t * (1 / 5 - t * (1 / 6 - t * (1 / 7 - t * 0.125)))))))
