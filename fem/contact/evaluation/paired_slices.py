"""Sixteen slices of a mesh law at a time, compiled: the usual case of at most two loaded pairs in a slice.

The mathematics stands in `fem.contact.evaluation.evaluator`. Every quantity of the first and of the second pair of a
slice is one row of LANES numbers in `work`, so that the compiler turns the loops over the lanes into vector
instructions. A pair that does not carry has ON = 0 and f = 0 there and its equation is f = 0, so all lanes run the same
instructions. A slice that is not of the usual kind gets RARE = 1 and is left to
`fem.contact.evaluation.general_slices`: three or more pairs that approach, neighbours that pull, a
pair switched off by the first guess though it carries, a line load beyond the range of the Hertz term, sweeps that do
not settle.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from fem.contact.evaluation.packing import (
    CELL,
    GAP,
    GRID,
    LANES,
    LEAD,
    NEXT,
    PART,
    PER_STEP,
    PHI,
    POSITIONS,
    PULLS,
    REACH,
    ROWS_PER_BLOCK,
    SHIFT,
    SLICE_ROWS,
    SLICES,
    SLOPE,
    START,
    VARIANTS,
    WHEEL_VARIANTS,
    WIDTH,
    B,
    C,
    Y,
)
from fem.numerics.compiled import PLAIN

# rows of the first pair; those of the second stand SECOND rows further
X, GAP_SLOPE, FRACTION, FRACTION_SLOPE, COMPLIANCE, COMPLIANCE_SLOPE, DEPTH, DEPTH_SLOPE = range(8)
LOAD, LOG, ON, PAIR, SCRATCH, EXPONENT = range(8, 14)
SECOND = 14
NEIGHBOUR, NEIGHBOUR_SLOPE, UPPER, LOWER, STEP, RARE = range(28, 34)
TOTAL = 34
NEVER = -1e300  # approach of a pair that cannot touch
CLOSE = 2e-6  # a Newton step this small (relative) leaves an error of about its square / 50
SERIES = 0.02  # largest relative step for the series of the logarithm
SWEEPS = 5
# columns of a pair near mesh: number, h, a1, a2, b1, b2, variants of the pinion and the wheel tooth
NUMBER, CLEARANCE, PROFILE, PROFILE_2, FACE, FACE_2, PINION_VARIANT, WHEEL_VARIANT = range(8)
_LN2 = math.log(2.0)
_BIAS = 4503599627370496.0 + 1023.0
_SERIES = (
    6.666666666666735130e-01,
    3.999999999940941908e-01,
    2.857142874366239149e-01,
    2.222219843214978396e-01,
    1.818357216161805012e-01,
    1.531383769920937332e-01,
    1.479819860511658591e-01,
)
_options: dict[str, Any] = {
    "forceinline": True,
    "fastmath": {"contract"},
}
_sums = {**_options, "fastmath": {"contract", "reassoc", "nsz"}}  # the order of the lanes in a sum is free


@njit(**PLAIN, **_options)
def gather(tables, block, own_cycle, states, near, n_near, work):
    """Fill the rows of the block with those of the pairs `near` (n_near, 8) that approach in one of two states.

    states (delta, psi, delta_0, psi_0); X belongs to the larger approach; p rises. False if nothing approaches.
    """
    base = SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    reach, pulls = int(tables[REACH]), tables[PULLS] != 0.0
    touched = False
    for s in range(LANES):
        here = own_cycle + tables[base + SHIFT * LANES + s]
        part, width = tables[base + PART * LANES + s], tables[base + WIDTH * LANES + s]
        approach = largest_approach(states, tables[base + Y * LANES + s]) - tables[base + LEAD * LANES + s]
        found, rare, ahead, ahead_inside, ahead_number = 0, 0.0, 0, 0.0, 0.0
        work[NEIGHBOUR, s] = work[NEIGHBOUR_SLOPE, s] = 0.0
        for m in range(n_near if width > 0.0 else 0):
            x, k, u = approach_of(tables, here, approach, part, near, m)
            if not x > (NEVER if pulls else 0.0):
                continue
            at = found * SECOND
            if found < 2:
                fill(tables, at, s, x, k, u, here, near, m, work)
            if near[m, PINION_VARIANT] != 0.0 or near[m, WHEEL_VARIANT] != 0.0:
                x = damaged(tables, block * LANES + s, at, s, x, k, u, near, m, work)
                if x <= 0.0:
                    continue
            if found == 2 or pulls:
                rare = 1.0
                break
            if found == 0:
                ahead, ahead_inside, ahead_number = k, u, near[m, NUMBER]
            else:
                apart = int(near[m, NUMBER] - ahead_number)
                if apart <= reach:
                    k = ahead + NEXT + 2 * (apart - 1)
                    work[NEIGHBOUR, s] = tables[k] + ahead_inside * tables[k + 1]
                    work[NEIGHBOUR_SLOPE, s] = tables[k + 1] * tables[PER_STEP]
            found += 1
        work[RARE, s] = rare
        touched = touched or found > 0 or rare > 0.0
        for a in range(0 if rare > 0.0 else found, 2):
            clear(a * SECOND, s, work)
    return touched


@njit(**PLAIN, **_options)
def approach_of(tables, here, approach, part, near, m):
    """Free approach x of near pair m (NEVER out of reach), place of its cell in `tables`, position inside the cell."""
    xi = here - near[m, NUMBER]
    place = (xi - tables[START]) * tables[PER_STEP]
    last = int(tables[POSITIONS]) - 1
    if not (place >= 0.0 and place <= last):
        return NEVER, 0, 0.0
    cell = min(int(place), last - 1)
    u = place - cell
    k = int(tables[GRID]) + cell * int(tables[CELL])
    if tables[k + PHI] + u * tables[k + PHI + 1] <= 0.0:
        return NEVER, 0, 0.0
    x = approach - tables[k + GAP] - u * tables[k + GAP + 1] - near[m, CLEARANCE]
    x -= xi * (near[m, PROFILE] + xi * near[m, PROFILE_2]) + part * (near[m, FACE] + part * near[m, FACE_2])
    return x, k, u


@njit(**PLAIN, **_options)
def fill(tables, at, s, x, k, u, here, near, m, work):
    """Rows `at` of lane s for near pair m of sound teeth."""
    per_step = tables[PER_STEP]
    xi = here - near[m, NUMBER]
    work[at + X, s] = x
    work[at + GAP_SLOPE, s] = tables[k + GAP + 1] * per_step + near[m, PROFILE] + 2.0 * near[m, PROFILE_2] * xi
    work[at + FRACTION, s] = tables[k + PHI] + u * tables[k + PHI + 1]
    work[at + FRACTION_SLOPE, s] = tables[k + PHI + 1] * per_step
    work[at + COMPLIANCE, s] = tables[k + C] + u * tables[k + C + 1]
    work[at + COMPLIANCE_SLOPE, s] = tables[k + C + 1] * per_step
    work[at + DEPTH, s] = tables[k + B] + u * tables[k + B + 1]
    work[at + DEPTH_SLOPE, s] = tables[k + B + 1] * per_step
    work[at + PAIR, s] = near[m, NUMBER]


@njit(**PLAIN, **_options)
def clear(at, s, work):
    """Rows `at` of lane s without a pair."""
    work[at + X, s], work[at + COMPLIANCE, s], work[at + FRACTION, s], work[at + DEPTH, s] = NEVER, 1.0, 0.0, 2.0
    work[at + GAP_SLOPE, s] = work[at + FRACTION_SLOPE, s] = 0.0
    work[at + COMPLIANCE_SLOPE, s] = work[at + DEPTH_SLOPE, s] = 0.0


@njit(**PLAIN)
def damaged(tables, slice_number, at, s, x, k, u, near, m, work):
    """Add to rows `at` of lane s what the damaged teeth of near pair m bring; returns the approach left."""
    positions, per_step = int(tables[POSITIONS]), tables[PER_STEP]
    slices = int(tables[SLICES])
    cell = (k - int(tables[GRID])) // int(tables[CELL])
    for begin, variant in ((VARIANTS, near[m, PINION_VARIANT]), (WHEEL_VARIANTS, near[m, WHEEL_VARIANT])):
        if variant > 0.0:
            i = int(tables[begin]) + (2 * (int(variant) - 1) * slices + slice_number) * positions + cell
            j = i + slices * positions
            if tables[j] == math.inf or tables[j + 1] == math.inf:
                return NEVER
            x -= tables[j] + u * (tables[j + 1] - tables[j])
            if at < 2 * SECOND:
                work[at + COMPLIANCE, s] += tables[i] + u * (tables[i + 1] - tables[i])
                work[at + COMPLIANCE_SLOPE, s] += (tables[i + 1] - tables[i]) * per_step
                work[at + GAP_SLOPE, s] += (tables[j + 1] - tables[j]) * per_step
                work[at + X, s] = x
    return x


@njit(**PLAIN, **_options)
def largest_approach(states, y):
    """The larger approach of the two states at face coordinate y."""
    return max(states[0] + states[1] * y, states[2] + states[3] * y)


@njit(**PLAIN, **_options)
def take_state(tables, block, states, before, after, work):
    """Move X from the approach `before` (0 or 1: a state; -1: the larger one) to that of the state `after`."""
    base = SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    for s in range(LANES):
        y = tables[base + Y * LANES + s]
        new = states[2 * after] + states[2 * after + 1] * y
        old = largest_approach(states, y) if before < 0 else states[0] + states[1] * y
        work[X, s] += new - old
        work[SECOND + X, s] += new - old
        work[LOAD, s] = work[LOAD, s] if work[LOAD, s] > 0.0 else 1.0
        work[SECOND + LOAD, s] = work[SECOND + LOAD, s] if work[SECOND + LOAD, s] > 0.0 else 1.0


@njit(**PLAIN, **_options)
def logarithm(work, bits):
    """ln of the rows LOAD into LOG, for positive numbers, to rounding (reduction and series of fdlibm, e_log.c)."""
    l1, l2, l3, l4, l5, l6, l7 = _SERIES
    for a in range(2):
        at = a * SECOND
        for s in range(LANES):
            k = bits[at + LOAD, s] + (0x3FF0000000000000 - 0x3FE6A09E667F3BCD)
            bits[at + SCRATCH, s] = (k & 0xFFFFFFFFFFFFF) + 0x3FE6A09E667F3BCD
            bits[at + EXPONENT, s] = (k >> 52) | 0x4330000000000000
        for s in range(LANES):
            f = work[at + SCRATCH, s] - 1.0
            q = f / (2.0 + f)
            z = q * q
            r = z * (l1 + z * (l2 + z * (l3 + z * (l4 + z * (l5 + z * (l6 + z * l7))))))
            work[at + LOG, s] = (work[at + EXPONENT, s] - _BIAS) * _LN2 + (f - (0.5 * f * f - q * (0.5 * f * f + r)))


@njit(**PLAIN, **_options)
def guess(slope, work, bits):
    """First line loads, about 1 % off, with a rough logarithm; a pair that its neighbour pushes out is switched off."""
    for s in range(LANES):
        x0, x1 = work[X, s], work[SECOND + X, s]
        work[LOAD, s] = x0 / work[COMPLIANCE, s] if x0 > 0.0 else 1.0
        work[SECOND + LOAD, s] = x1 / work[SECOND + COMPLIANCE, s] if x1 > 0.0 else 1.0
    for s in range(LANES):
        c0, c1 = work[COMPLIANCE, s], work[SECOND + COMPLIANCE, s]
        rough0 = (bits[LOAD, s] * 2.0**-52 - 1022.957) * _LN2
        rough1 = (bits[SECOND + LOAD, s] * 2.0**-52 - 1022.957) * _LN2
        d0 = c0 + slope * max(1.0, work[DEPTH, s] - rough0)
        d1 = c1 + slope * max(1.0, work[SECOND + DEPTH, s] - rough1)
        d0, d1 = d0 + 2.0 * slope * (d0 - c0) / (d0 + c0), d1 + 2.0 * slope * (d1 - c1) / (d1 + c1)
        x0, x1 = max(work[X, s], 0.0), max(work[SECOND + X, s], 0.0)
        u = work[NEIGHBOUR, s] * work[SECOND + FRACTION, s]
        v = work[NEIGHBOUR, s] * work[FRACTION, s]
        scale = 1.0 / (d0 * d1 - u * v)
        f0, f1 = (d1 * x0 - u * x1) * scale, (d0 * x1 - v * x0) * scale
        on0, on1 = f0 > 0.0, f1 > 0.0
        f0 = f0 if on1 else x0 / d0
        f1 = f1 if on0 else x1 / d1
        work[ON, s], work[SECOND + ON, s] = 1.0 if on0 else 0.0, 1.0 if on1 else 0.0
        work[LOAD, s], work[SECOND + LOAD, s] = f0 if on0 else 1.0, f1 if on1 else 1.0
        work[UPPER, s], work[LOWER, s] = u if on0 and on1 else 0.0, v if on0 and on1 else 0.0
    logarithm(work, bits)


@njit(**PLAIN, **_sums)
def sweep(slope, work, bits):
    """One Newton step of all line loads; returns the sum of the squares of the relative steps."""
    total = 0.0
    for s in range(LANES):
        f0, f1, log0, log1 = work[LOAD, s], work[SECOND + LOAD, s], work[LOG, s], work[SECOND + LOG, s]
        c0, c1, u, v = work[COMPLIANCE, s], work[SECOND + COMPLIANCE, s], work[UPPER, s], work[LOWER, s]
        depth0, depth1 = work[DEPTH, s] - log0, work[SECOND + DEPTH, s] - log1
        d0, d1 = c0 + slope * max(depth0 - 1.0, 0.0), c1 + slope * max(depth1 - 1.0, 0.0)
        r0 = work[ON, s] * (work[X, s] - f0 * (c0 + slope * depth0) - u * f1)
        r1 = work[SECOND + ON, s] * (work[SECOND + X, s] - f1 * (c1 + slope * depth1) - v * f0)
        scale = 1.0 / ((d0 * d1 - u * v) * f0 * f1)
        step0, step1 = (d1 * r0 - u * r1) * scale * f1, (d0 * r1 - v * r0) * scale * f0
        step0, step1 = max(step0, -0.95), max(step1, -0.95)
        work[LOAD, s], work[SECOND + LOAD, s] = f0 + f0 * step0, f1 + f1 * step1
        work[LOG, s], work[SECOND + LOG, s] = log0 + log_of_growth(step0), log1 + log_of_growth(step1)
        square = step0 * step0 + step1 * step1
        work[STEP, s] = square
        total += square
    if total > SERIES * SERIES:
        logarithm(work, bits)
    return total


@njit(**PLAIN, **_options)
def log_of_growth(t):
    """ln(1 + t), to rounding up to |t| = SERIES."""
    return t * (1 - t * (1 / 2 - t * (1 / 3 - t * (1 / 4 - t * (1 / 5 - t * (1 / 6 - t * (1 / 7 - t * 0.125)))))))


@njit(**PLAIN, **_sums)
def switch_off(slope, work):
    """f = 0 where a pair does not carry; RARE = 1 where the answer does not hold; returns their number."""
    rare = 0.0
    for s in range(LANES):
        on0, on1 = work[ON, s], work[SECOND + ON, s]
        f0, f1 = work[LOAD, s] * on0, work[SECOND + LOAD, s] * on1
        x0, x1 = work[X, s], work[SECOND + X, s]
        idle0 = x0 - work[NEIGHBOUR, s] * work[SECOND + FRACTION, s] * f1
        idle1 = x1 - work[NEIGHBOUR, s] * work[FRACTION, s] * f0
        bad = 0.0
        bad = 1.0 if on0 == 0.0 and idle0 > 1e-15 * abs(x0) else bad
        bad = 1.0 if on1 == 0.0 and idle1 > 1e-15 * abs(x1) else bad
        bad = 1.0 if on0 * (work[LOG, s] + 1.0 - work[DEPTH, s]) > 0.0 and slope > 0.0 else bad
        bad = 1.0 if on1 * (work[SECOND + LOG, s] + 1.0 - work[SECOND + DEPTH, s]) > 0.0 and slope > 0.0 else bad
        bad = 1.0 if work[STEP, s] > CLOSE * CLOSE else bad
        bad = max(work[RARE, s], bad)
        work[RARE, s] = bad
        work[LOAD, s], work[SECOND + LOAD, s] = f0 if bad == 0.0 else 0.0, f1 if bad == 0.0 else 0.0
        work[LOG, s], work[SECOND + LOG, s] = work[LOG, s] * (1.0 - bad), work[SECOND + LOG, s] * (1.0 - bad)
        work[ON, s], work[SECOND + ON, s] = on0 * (1.0 - bad), on1 * (1.0 - bad)
        rare += bad
    return rare


@njit(**PLAIN, **_sums)
def block_sums(tables, block, work):
    """F, M, U, k, k y, k y^2 and dU/dc' of the slices of the block that are not rare."""
    slope, base = tables[SLOPE], SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    force = moment = energy = k = mixed = tilt = rate = 0.0
    for s in range(LANES):
        y, w = tables[base + Y * LANES + s], tables[base + WIDTH * LANES + s] * (1.0 - work[RARE, s])
        f0, f1, phi0, phi1 = work[LOAD, s], work[SECOND + LOAD, s], work[FRACTION, s], work[SECOND + FRACTION, s]
        c0, c1, u, v = work[COMPLIANCE, s], work[SECOND + COMPLIANCE, s], work[UPPER, s], work[LOWER, s]
        depth0, depth1 = work[DEPTH, s] - work[LOG, s], work[SECOND + DEPTH, s] - work[SECOND + LOG, s]
        d0, d1 = c0 + slope * max(depth0 - 1.0, 0.0), c1 + slope * max(depth1 - 1.0, 0.0)
        on0, on1 = work[ON, s] * phi0, work[SECOND + ON, s] * phi1
        stiff = w * (on0 * (d1 - u) + on1 * (d0 - v)) / (d0 * d1 - u * v)
        stiff = w * on0 / d0 if on1 == 0.0 else stiff
        stiff = w * on1 / d1 if on0 == 0.0 else stiff
        load = w * (phi0 * f0 + phi1 * f1)
        force += load
        moment += load * y
        k += stiff
        mixed += stiff * y
        tilt += stiff * y * y
        half0, half1 = 0.5 * f0 * f0, 0.5 * f1 * f1
        own0 = max(work[X, s], 0.0) * f0 - half0 * (c0 + slope * (depth0 + 0.5))
        own1 = max(work[SECOND + X, s], 0.0) * f1 - half1 * (c1 + slope * (depth1 + 0.5))
        both = f0 * f1
        energy += w * (phi0 * own0 + phi1 * own1 - work[NEIGHBOUR, s] * phi0 * phi1 * both)
        along0 = f0 * work[GAP_SLOPE, s] + half0 * (work[COMPLIANCE_SLOPE, s] + slope * work[DEPTH_SLOPE, s])
        along1 = f1 * work[SECOND + GAP_SLOPE, s]
        along1 += half1 * (work[SECOND + COMPLIANCE_SLOPE, s] + slope * work[SECOND + DEPTH_SLOPE, s])
        slope0, slope1 = work[FRACTION_SLOPE, s], work[SECOND + FRACTION_SLOPE, s]
        steep = work[NEIGHBOUR_SLOPE, s] * phi0 * phi1 + work[NEIGHBOUR, s] * (slope0 * phi1 + slope1 * phi0)
        rate += w * (slope0 * own0 + slope1 * own1 - phi0 * along0 - phi1 * along1 - steep * both)
    return force, moment, energy, k, mixed, tilt, rate
