"""Line loads, fields and body displacements of a coupled mesh law in one Newton iteration, compiled.

The equations stand in `fem.contact.evaluation.coupled_face`; here the slices need not be solved before the fields move.
Let l = f + J^-1 r be the loads after a Newton step of every slice by itself at the free approach (no field, no body
displacement). With fields and bodies they are f = l - J^-1 (g v + d + t y), and the linear problem of the step reads,
with K = phi J^-1,

    (T + w g K g) v = w g phi l - w g K 1 (d + t y),    (d, t) = E (F, M).

A slice loads at most two pairs, so the lines of the even and of the odd pairs never meet in one slice: two fields are
enough however many pairs the face holds, and the matrix is tridiagonal in blocks of 2 x 2. The part of a line before
its first and behind its last touched slice acts like one spring (rows BEFORE, BEHIND of
`fem.contact.evaluation.packing`). The elimination runs from both ends of the face to its middle; what the bodies need
falls off on the way, so that only one solution is substituted back. All else runs over sixteen slices at a time, as in
`fem.contact.evaluation.paired_slices`.

A pair leaves a slice when its load falls below zero and returns where its approach is positive.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from fem.contact.evaluation import paired_slices
from fem.contact.evaluation.packing import (
    BEFORE,
    BEHIND,
    CELL,
    GRID,
    LANES,
    LENGTH,
    NEXT,
    PER_STEP,
    POSITIONS,
    REACH,
    ROWS_PER_BLOCK,
    SHIFT,
    SLICE_ROWS,
    SLOPE,
    SPRING,
    START,
    WIDTH,
    Y,
)
from fem.contact.evaluation.paired_slices import (
    COMPLIANCE,
    DEPTH,
    FRACTION,
    LOAD,
    LOG,
    NEIGHBOUR,
    NEVER,
    ON,
    PAIR,
    SECOND,
    X,
)
from fem.numerics.compiled import PLAIN

STEPS = 14
CLOSE = 1e-12  # of F: error at which the iteration ends
# rows after those of `paired_slices`; of two, the second belongs to the odd pairs
WIDEST, FREE, GAIN, GAIN_SLOPE, FIELD, LINK, STAY, LINEAR, RIGHT = range(
    paired_slices.TOTAL, paired_slices.TOTAL + 18, 2
)
SWAP, K00, K01, K11, A00, A01, A11, P0, P1, Z0, Z1 = range(paired_slices.TOTAL + 18, paired_slices.TOTAL + 29)
TOTAL = paired_slices.TOTAL + 29
_inline: dict[str, Any] = {"forceinline": True, "fastmath": {"contract"}}
_sums = {**_inline, "fastmath": {"contract", "reassoc", "nsz"}}
_LN2 = 0.6931471805599453


@njit(**PLAIN, **_inline)
def prepare(tables, block, own_cycle, rows):
    """Put odd pairs into the second rows and read sqrt(D); False where both pairs of a slice are odd or even."""
    base = SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    good = True
    for s in range(LANES):
        there0, there1 = rows[X, s] > NEVER, rows[SECOND + X, s] > NEVER
        odd = int(rows[PAIR, s]) & 1 if there0 else 0
        if there0 and there1:
            good = good and (int(rows[SECOND + PAIR, s]) & 1) != odd
        rows[SWAP, s] = float(odd)
    for row in range(DEPTH + 2):
        for s in range(LANES):
            a, b, odd = rows[row, s], rows[SECOND + row, s], rows[SWAP, s] > 0.0
            rows[row, s], rows[SECOND + row, s] = b if odd else a, a if odd else b
    for s in range(LANES):
        a, b, odd = rows[PAIR, s], rows[SECOND + PAIR, s], rows[SWAP, s] > 0.0
        rows[PAIR, s], rows[SECOND + PAIR, s] = b if odd else a, a if odd else b
    column = int(tables[GRID]) + NEXT + 2 * int(tables[REACH])
    size, last, spread = int(tables[CELL]), int(tables[POSITIONS]) - 2, tables[LENGTH] > 0.0
    for a in range(2):
        for s in range(LANES):
            x = rows[a * SECOND + X, s]
            rows[WIDEST + a, s] = x
            rows[LINK + a, s] = rows[FIELD + a, s] = 0.0
            g = steep = 0.0
            if spread and x > NEVER:
                xi = own_cycle + tables[base + SHIFT * LANES + s] - rows[a * SECOND + PAIR, s]
                place = (xi - tables[START]) * tables[PER_STEP]
                cell = min(int(place), last)
                k = column + cell * size
                g, steep = tables[k] + (place - cell) * tables[k + 1], tables[k + 1] * tables[PER_STEP]
            rows[GAIN + a, s], rows[GAIN_SLOPE + a, s] = g, steep
    return good


@njit(**PLAIN, **_inline)
def link(tables, n_s, work):
    """Springs between the slices that one line runs through; False where a line comes back after another."""
    good = True
    for a in range(2):
        last, number, direction = -1, 0.0, 0.0
        for s in range(n_s):
            top, lane = (s // LANES) * TOTAL, s % LANES
            if work[top + a * SECOND + X, lane] > NEVER:
                found = work[top + a * SECOND + PAIR, lane]
                if last >= 0 and found == number:
                    for j in range(last, s):
                        base = SLICE_ROWS + ((j // LANES) * ROWS_PER_BLOCK + SPRING) * LANES + j % LANES
                        work[(j // LANES) * TOTAL + LINK + a, j % LANES] = tables[base]
                elif last >= 0:
                    good = good and direction * (found - number) >= 0.0
                    direction = found - number
                last, number = s, found
        behind = 0.0
        for s in range(n_s):
            top, lane = (s // LANES) * TOTAL, s % LANES
            base = SLICE_ROWS + (s // LANES) * ROWS_PER_BLOCK * LANES + lane
            ahead = work[top + LINK + a, lane]
            stay = tables[base + WIDTH * LANES] + (behind if behind > 0.0 else tables[base + BEFORE * LANES])
            work[top + STAY + a, lane] = stay + (ahead if ahead > 0.0 else tables[base + BEHIND * LANES])
            behind = ahead
    return good


@njit(**PLAIN, **_inline)
def take_state(tables, block, states, which, rows):
    """Free approaches of the state `which`; rows WIDEST belong to the larger approach of the two states."""
    base = SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    for s in range(LANES):
        y = tables[base + Y * LANES + s]
        back = paired_slices.largest_approach(states, y) - (states[2 * which] + states[2 * which + 1] * y)
        rows[FREE, s], rows[FREE + 1, s] = rows[WIDEST, s] - back, rows[WIDEST + 1, s] - back


@njit(**PLAIN, **_sums)
def estimate(tables, block, rows, bits):
    """Secant compliances into P0, P1 as if all slices were loaded alike, and the sums F, M, k, k y, k y^2 with them."""
    slope, base = tables[SLOPE], SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    force = moment = k = mixed = tilt = 0.0
    for a in range(2):
        at = a * SECOND
        for s in range(LANES):
            x = rows[FREE + a, s]
            soft = rows[at + COMPLIANCE, s] + rows[GAIN + a, s] * rows[GAIN + a, s]
            rows[P0 + a, s] = soft
            rows[at + LOAD, s] = x / (soft + 5.0 * slope) if x > 0.0 else 1.0
        for s in range(LANES):
            y, x = tables[base + Y * LANES + s], rows[FREE + a, s]
            rough = (bits[at + LOAD, s] * 2.0**-52 - 1022.957) * _LN2
            soft = rows[P0 + a, s] + slope * max(1.0, rows[at + DEPTH, s] - rough)
            rows[P0 + a, s] = soft
            stiff = tables[base + WIDTH * LANES + s] * rows[at + FRACTION, s] / soft
            stiff, load = stiff if x > 0.0 else 0.0, stiff * x if x > 0.0 else 0.0
            force += load
            moment += load * y
            k += stiff
            mixed += stiff * y
            tilt += stiff * y * y
    return force, moment, k, mixed, tilt


@njit(**PLAIN, **_inline)
def start(tables, block, d, t, rows, bits):
    """First line loads, from the secant compliances at the body displacements d, t."""
    base = SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    for a in range(2):
        at = a * SECOND
        for s in range(LANES):
            x = rows[FREE + a, s] - d - t * tables[base + Y * LANES + s]
            f = x / rows[P0 + a, s]
            rows[at + ON, s], rows[at + LOAD, s] = 1.0 if x > 0.0 else 0.0, f if x > 0.0 else 1.0
    paired_slices.logarithm(rows, bits)


@njit(**PLAIN, **_sums)
def linearise(tables, block, rows):
    """phi l, K and the block's part of the field equations; returns the sums F, M, k, k y, k y^2 without fields."""
    slope, base = tables[SLOPE], SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    force = moment = k = mixed = tilt = 0.0
    for s in range(LANES):
        y, w = tables[base + Y * LANES + s], tables[base + WIDTH * LANES + s]
        on0, on1 = rows[ON, s], rows[SECOND + ON, s]
        phi0, phi1, f0, f1 = rows[FRACTION, s], rows[SECOND + FRACTION, s], rows[LOAD, s], rows[SECOND + LOAD, s]
        depth0, depth1 = rows[DEPTH, s] - rows[LOG, s], rows[SECOND + DEPTH, s] - rows[SECOND + LOG, s]
        c0, c1 = rows[COMPLIANCE, s], rows[SECOND + COMPLIANCE, s]
        d0, d1 = c0 + slope * max(depth0 - 1.0, 0.0), c1 + slope * max(depth1 - 1.0, 0.0)
        both = rows[NEIGHBOUR, s] * on0 * on1
        u, v = both * phi1, both * phi0
        r0 = on0 * (rows[FREE, s] - f0 * (c0 + slope * depth0) - u * f1)
        r1 = on1 * (rows[FREE + 1, s] - f1 * (c1 + slope * depth1) - v * f0)
        scale = 1.0 / (d0 * d1 - u * v)
        k00, k01, k11 = on0 * phi0 * d1 * scale, -phi0 * u * scale, on1 * phi1 * d0 * scale
        l0 = phi0 * (on0 * f0 + (d1 * r0 - u * r1) * scale)
        l1 = phi1 * (on1 * f1 + (d0 * r1 - v * r0) * scale)
        rows[K00, s], rows[K01, s], rows[K11, s] = k00, k01, k11
        rows[LINEAR, s], rows[LINEAR + 1, s] = l0, l1
        g0, g1 = rows[GAIN, s], rows[GAIN + 1, s]
        rows[A00, s] = rows[STAY, s] + w * g0 * g0 * k00
        rows[A01, s] = w * g0 * g1 * k01
        rows[A11, s] = rows[STAY + 1, s] + w * g1 * g1 * k11
        rows[RIGHT, s], rows[RIGHT + 1, s] = w * g0 * l0, w * g1 * l1
        rows[P0, s], rows[P1, s] = w * g0 * (k00 + k01), w * g1 * (k01 + k11)
        stiff, load = w * (k00 + 2.0 * k01 + k11), w * (l0 + l1)
        force += load
        moment += load * y
        k += stiff
        mixed += stiff * y
        tilt += stiff * y * y
    return force, moment, k, mixed, tilt


@njit(**PLAIN, **_sums)
def advance(tables, block, d, t, rows, bits):
    """Loads at the fields and body displacements; FREE keeps the free approach, X takes what is left to the slice.

    Returns F, the bound sum w K A f step^2 / 2 of its error, from x'' = -A / f, with the relative steps of the loads,
    and the sum of step^2, 1 for a pair that switches.
    """
    slope, base = tables[SLOPE], SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    force = bend = total = 0.0
    for s in range(LANES):
        w = tables[base + WIDTH * LANES + s]
        move = d + t * tables[base + Y * LANES + s]
        move0, move1 = move + rows[GAIN, s] * rows[FIELD, s], move + rows[GAIN + 1, s] * rows[FIELD + 1, s]
        phi0, phi1, f0, f1 = rows[FRACTION, s], rows[SECOND + FRACTION, s], rows[LOAD, s], rows[SECOND + LOAD, s]
        on0, on1 = rows[ON, s] > 0.0, rows[SECOND + ON, s] > 0.0
        new0 = rows[LINEAR, s] - rows[K00, s] * move0 - rows[K01, s] * move1
        new1 = rows[LINEAR + 1, s] - rows[K01, s] * move0 - rows[K11, s] * move1
        new0, new1 = new0 / (phi0 if on0 else 1.0), new1 / (phi1 if on1 else 1.0)
        stays0, stays1 = on0 and new0 > 0.0, on1 and new1 > 0.0
        x0, x1 = rows[FREE, s] - move0, rows[FREE + 1, s] - move1
        rows[X, s], rows[SECOND + X, s] = x0, x1
        left0 = x0 - rows[NEIGHBOUR, s] * phi1 * (new1 if stays1 else 0.0)
        left1 = x1 - rows[NEIGHBOUR, s] * phi0 * (new0 if stays0 else 0.0)
        back0 = not on0 and left0 > 1e-15 * abs(rows[FREE, s]) and left0 > 1e-18
        back1 = not on1 and left1 > 1e-15 * abs(rows[FREE + 1, s]) and left1 > 1e-18
        fresh0 = left0 / (rows[COMPLIANCE, s] + 0.8 * slope * rows[DEPTH, s])
        fresh1 = left1 / (rows[SECOND + COMPLIANCE, s] + 0.8 * slope * rows[SECOND + DEPTH, s])
        new0 = new0 if stays0 else (fresh0 if back0 else 1.0)
        new1 = new1 if stays1 else (fresh1 if back1 else 1.0)
        step0 = (new0 - f0) / f0 if stays0 else (1.0 if on0 or back0 else 0.0)
        step1 = (new1 - f1) / f1 if stays1 else (1.0 if on1 or back1 else 0.0)
        rows[LOAD, s], rows[SECOND + LOAD, s] = new0, new1
        rows[ON, s], rows[SECOND + ON, s] = 1.0 if stays0 or back0 else 0.0, 1.0 if stays1 or back1 else 0.0
        rows[LOG, s] += paired_slices.log_of_growth(step0)
        rows[SECOND + LOG, s] += paired_slices.log_of_growth(step1)
        load0, load1 = w * phi0 * new0 if stays0 else 0.0, w * phi1 * new1 if stays1 else 0.0
        force += load0 + load1
        bend += w * (rows[K00, s] * step0 * step0 * new0 + rows[K11, s] * step1 * step1 * new1)
        total += step0 * step0 + step1 * step1
    if total > paired_slices.SERIES * paired_slices.SERIES:
        paired_slices.logarithm(rows, bits)
    return force, 0.5 * slope * bend, total


@njit(**PLAIN, **_sums)
def finish(tables, block, rows):
    """Idle pairs to f = 0, as `paired_slices.block_sums` wants them.

    Returns the sums of w sqrt(D) phi f v and of w (sqrt(D))' phi f v, and the number of loads beyond the range of the
    Hertz term.
    """
    slope, base = tables[SLOPE], SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    held = along = beyond = 0.0
    for s in range(LANES):
        w = tables[base + WIDTH * LANES + s]
        on0, on1 = rows[ON, s], rows[SECOND + ON, s]
        depth0, depth1 = rows[DEPTH, s] - rows[LOG, s], rows[SECOND + DEPTH, s] - rows[SECOND + LOG, s]
        beyond += on0 if slope > 0.0 and depth0 < 1.0 else 0.0
        beyond += on1 if slope > 0.0 and depth1 < 1.0 else 0.0
        f0, f1 = rows[LOAD, s] * on0, rows[SECOND + LOAD, s] * on1
        rows[LOAD, s], rows[SECOND + LOAD, s] = f0, f1
        both, phi0, phi1 = rows[NEIGHBOUR, s] * on0 * on1, rows[FRACTION, s], rows[SECOND + FRACTION, s]
        rows[paired_slices.UPPER, s], rows[paired_slices.LOWER, s], rows[paired_slices.RARE, s] = (
            both * phi1,
            both * phi0,
            0.0,
        )
        h0, h1 = w * phi0 * f0 * rows[FIELD, s], w * phi1 * f1 * rows[FIELD + 1, s]
        held += rows[GAIN, s] * h0 + rows[GAIN + 1, s] * h1
        along += rows[GAIN_SLOPE, s] * h0 + rows[GAIN_SLOPE + 1, s] * h1
    return held, along, beyond


@njit(**PLAIN, **_inline)
def resume(rows):
    """Loads of a finished block as the start of the next state."""
    for s in range(LANES):
        for a in range(2):
            if rows[a * SECOND + ON, s] == 0.0:
                rows[a * SECOND + LOAD, s], rows[a * SECOND + LOG, s] = 1.0, 0.0
