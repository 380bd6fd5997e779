"""Tooth pairs near mesh, compiled: which pairs may touch somewhere on the face, and what their teeth bring."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fem.contact.evaluation.law_tables import LARGEST_NEAR
from fem.numerics.compiled import INLINE, inner, views


class NearPairs(NamedTuple):
    """Pairs in rising order, arrays (pair,); the terms of both teeth of a pair are added, see `fem.contact.teeth`."""

    pairs: int
    number: np.ndarray  # p
    clearance: np.ndarray  # h, m
    profile_slope: np.ndarray  # a1, m
    profile_curvature: np.ndarray  # a2, m
    lead_slope: np.ndarray  # b1, m
    lead_curvature: np.ndarray  # b2, m
    pinion_variant: np.ndarray  # 0 for a sound tooth
    wheel_variant: np.ndarray


NEAR_ROOM = LARGEST_NEAR * (len(NearPairs._fields) - 1)  # numbers of memory


@inner(**INLINE)
def near_pairs(law, own_cycle, pinion, wheel, memory):
    """The pairs with both teeth that may touch somewhere on the face.

    Parameters
    ----------
    law : `LawTables`
    own_cycle : c' of the law
    pinion, wheel : (z1, 6) and (z2, 6) tooth terms, see `fem.contact.teeth`
    memory : (n,) out: the first NEAR_ROOM numbers hold the arrays
    """
    table = views(memory, 0, 8, (LARGEST_NEAR,))
    sign = 1 if law.sign > 0.0 else -1
    z1, z2 = pinion.shape[0], wheel.shape[0]
    first = math.ceil(own_cycle + law.first_shift - law.start - law.cells / law.per_step)
    last = min(math.floor(own_cycle + law.last_shift - law.start), first + LARGEST_NEAR - 1)
    i, j = (sign * first) % z1, (sign * first + int(law.wheel_offset)) % z2
    n = 0
    for p in range(first, last + 1):
        if pinion[i, 0] + wheel[j, 0] < math.inf:
            table[0][n] = p
            for k in range(5):
                table[1 + k][n] = pinion[i, k] + wheel[j, k]
            table[6][n], table[7][n] = pinion[i, 5], wheel[j, 5]
            n += 1
        i, j = i + sign, j + sign
        i, j = i - z1 if i >= z1 else i, j - z2 if j >= z2 else j
        i, j = i + z1 if i < 0 else i, j + z2 if j < 0 else j
    return NearPairs(n, *table)


@inner()
def damaged_teeth(law, own_cycle, pinion, wheel, found):
    """Number of the teeth with modes on the pairs near mesh and beside them.

    Parameters
    ----------
    law, own_cycle, pinion, wheel : as for `near_pairs`
    found : (n, 3) out: pair, 0 pinion or 1 wheel, variant; (0, 0) if only their number is asked for
    """
    sign, count = 1 if law.sign > 0.0 else -1, 0
    first = math.ceil(own_cycle + law.first_shift - law.start - law.cells / law.per_step) - 1
    last = min(math.floor(own_cycle + law.last_shift - law.start) + 1, first + LARGEST_NEAR - 1)
    for p in range(first, last + 1):
        of_pinion = pinion[(sign * p) % pinion.shape[0], 5] if law.pinion_modes > 0.0 else 0.0
        of_wheel = wheel[(sign * p + int(law.wheel_offset)) % wheel.shape[0], 5] if law.wheel_modes > 0.0 else 0.0
        for gear, variant in ((0.0, of_pinion), (1.0, of_wheel)):
            if variant > 0.0:
                if found.size > 0:
                    found[count, 0], found[count, 1], found[count, 2] = p, gear, variant
                count += 1
    return count
