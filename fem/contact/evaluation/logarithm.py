"""Natural logarithm of rows of sixteen numbers by vector instructions, compiled.

Without a vector library the compiler calls the logarithm of the C library number by number: 87 ns for 32 numbers, 40 ns
by this one (one core of an Intel Xeon of 2023; reduction and series of fdlibm, e_log.c). An evaluation takes two to
four times 32 logarithms of 1 to 2 us in all.
"""

from __future__ import annotations

import math

import numpy as np

from fem.contact.evaluation.law_tables import LANES
from fem.numerics.compiled import INLINE, inner

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
    1.479819860511658591e-01,
)


@inner(**INLINE)
def logarithm(values, logs, scratch):
    """ln of `values` into `logs`, to rounding; all (row, LANES), normal positive numbers; `scratch` is overwritten."""
    bits, exponent, mantissa = values.view(np.int64), logs.view(np.int64), scratch.view(np.int64)
    for a in range(len(values)):
        for s in range(LANES):
            k = bits[a, s] + (_ONE - _HALF_ROOT)
            mantissa[a, s] = (k & 0xFFFFFFFFFFFFF) + _HALF_ROOT
            exponent[a, s] = (k >> 52) | 0x4330000000000000
            f = scratch[a, s] - 1.0
            q = f / (2.0 + f)
            z = q * q
            r = z * (_L1 + z * (_L2 + z * (_L3 + z * (_L4 + z * (_L5 + z * (_L6 + z * _L7))))))
            logs[a, s] = (logs[a, s] - _BIAS) * _LN2 + (f - (0.5 * f * f - q * (0.5 * f * f + r)))


@inner(**INLINE)
def rough_log(bits):
    """ln of a number from its bits, within 0.03."""
    return (bits * 2.0**-52 - 1022.957) * _LN2


@inner(**INLINE)
def log_of_growth(t):
    """ln(1 + t), to rounding up to |t| = SERIES."""
    return t * (1 - t * (1 / 2 - t * (1 / 3 - t * (1 / 4 - t * (1 / 5 - t * (1 / 6 - t * (1 / 7 - t * 0.125)))))))
