"""Tooth pairs near mesh, compiled: which pairs may touch somewhere on the face, and what their teeth bring."""

from __future__ import annotations

import math

from numba import njit

from fem.contact.evaluation import paired_slices
from fem.contact.evaluation.packing import (
    FIRST_SHIFT,
    LARGEST_NEAR,
    LAST_SHIFT,
    PER_STEP,
    POSITIONS,
    SIGN,
    START,
    WHEEL_OFFSET,
)
from fem.numerics.compiled import PLAIN


@njit(**PLAIN)
def pairs_near(tables, own_cycle, pinion, wheel, near):
    """Pairs with both teeth that may touch somewhere on the face, rows of `near` in rising order; their number."""
    sign = 1 if tables[SIGN] > 0.0 else -1
    z1, z2 = pinion.shape[0], wheel.shape[0]
    start, span = tables[START], (tables[POSITIONS] - 1.0) / tables[PER_STEP]
    first = math.ceil(own_cycle + tables[FIRST_SHIFT] - start - span)
    last = min(math.floor(own_cycle + tables[LAST_SHIFT] - start), first + LARGEST_NEAR - 1)
    i, j = (sign * first) % z1, (sign * first + int(tables[WHEEL_OFFSET])) % z2
    n = 0
    for p in range(first, last + 1):
        h = pinion[i, 0] + wheel[j, 0]
        if h < math.inf:
            near[n, paired_slices.NUMBER], near[n, paired_slices.CLEARANCE] = p, h
            for k in range(1, 5):
                near[n, paired_slices.CLEARANCE + k] = pinion[i, k] + wheel[j, k]
            near[n, paired_slices.PINION_VARIANT], near[n, paired_slices.WHEEL_VARIANT] = pinion[i, 5], wheel[j, 5]
            n += 1
        i, j = i + sign, j + sign
        i, j = i - z1 if i >= z1 else i, j - z2 if j >= z2 else j
        i, j = i + z1 if i < 0 else i, j + z2 if j < 0 else j
    return n
