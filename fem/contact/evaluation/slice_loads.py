"""Line loads of sixteen slices that are independent of one another, compiled.

In a slice the loaded pairs p, q obey x_p = C f_p + A f_p (B - ln f_p) + sum_q c_pq phi_q f_q; a pair without load has
no approach left. x(f) is nearly a straight line, because ln f changes little: secant compliances with a rough logarithm
give f within a few per cent, and each Newton step then squares the error and divides it by 50, so that two or three
steps reach round-off. A pair that does not carry has f = 1 and a right-hand side of 0, so all lanes run the same
instructions. A slice in contact on a part of its width starts from the load of a whole one that carries about the same,
and takes a step more. Lanes where that does not hold (a pair switched off by the guess though it carries, a load beyond
the range of the Hertz term, steps that do not settle) are solved anew by coordinate descent, pair by pair, which always
converges for a convex function.
"""

from __future__ import annotations

import numpy as np
from numba import njit, types

from fem.contact.evaluation.hertz import compliance_of, exceeded, secant_compliance, single_load
from fem.contact.evaluation.law_tables import LANES
from fem.contact.evaluation.logarithm import SERIES, log_of_growth, logarithm, rough_log
from fem.contact.evaluation.slice_rows import invert, rows_in
from fem.contact.part_contact import part_of, spared, spared_compliance, touch
from fem.numerics.compiled import FLOAT, INLINE, INTEGER, SPREAD, SUMS, VECTOR, apart, inner, stored

CLOSE = 2e-6  # a Newton step this small (relative) leaves an error of about its square / 50
STEPS = 7


@njit(**SPREAD)
def solve_slices(slope, cold, rows):
    """Loads of the block at the approaches of the rows, from scratch or from the loads there are (slope: A)."""
    if cold:
        _guess(slope, rows)
    for _ in range(STEPS):
        if _newton_step(slope, rows) <= CLOSE * CLOSE:
            break
    if _finish(slope, rows) > 0.0:
        for s in range(LANES):
            if rows.rare[s] > 0.0:
                _descend(slope, rows.memory, len(rows.order), s)


@inner(**INLINE)
def move_approach(states, which, rows):
    """From the larger approach of two states to that of state 0, or from that to state 1, with loads to start from."""
    for s in range(LANES):
        y = rows.y[s]
        first, second = states.delta + states.psi * y, states.other_delta + states.other_psi * y
        change = first - max(first, second) if which == 0 else second - first
        for a in range(len(rows.order)):
            rows.approach[a, s] += change
            rows.load[a, s] = rows.load[a, s] if rows.load[a, s] > 0.0 else 1.0


@inner(**INLINE)
def _guess(slope, rows):
    """First line loads, about 1 % off; pairs that their neighbours push out are switched off."""
    n, bits, secant = len(rows.order), rows.load.view(np.int64), rows.rest
    for s in range(LANES):
        for a in range(n):
            x = touch(rows.approach[a, s], rows.rise[a, s], rows.even[a, s])
            c = rows.compliance[a, s]
            rows.on[a, s], rows.beyond[a, s] = 1.0 if x > 0.0 else 0.0, x
            rows.load[a, s] = x / c
            secant[a, s] = secant_compliance(c, slope, rows.offset[a, s] - rough_log(bits[a, s]))
    for _ in range(2):
        for s in range(LANES):
            couple(rows, s)
            for a in range(n):
                for b in range(n):
                    rows.system[a, b, s] = secant[a, s] if a == b else rows.pull[a, b, s]
            invert(rows.order, rows.system, s)
            for a in range(n):
                f = 0.0
                for b in range(n):
                    f += rows.system[a, b, s] * rows.on[b, s] * rows.beyond[b, s]
                rows.load[a, s] = f
            for a in range(n):
                f = rows.load[a, s]
                rows.on[a, s], rows.load[a, s] = 1.0 if f > 0.0 else 0.0, f if f > 0.0 else 1.0
    for s in range(LANES):
        couple(rows, s)
    logarithm(rows.load, rows.log, rows.rest)


@inner(**INLINE)
def couple(rows, s):
    """c_pq phi_q between the pairs of lane s that carry."""
    n = len(rows.order)
    for a in range(n):
        for b in range(n):
            both = rows.on[a, s] * rows.on[b, s]
            rows.pull[a, b, s] = both * rows.neighbour[a, b, s] * rows.fraction[b, s]


@inner(**SUMS)
def _newton_step(slope, rows):
    """One step of all line loads; returns the sum of the squares of the relative steps."""
    n, total = len(rows.order), 0.0
    for s in range(LANES):
        for a in range(n):
            f, depth = rows.load[a, s], rows.offset[a, s] - rows.log[a, s]
            rise, per_whole, even = rows.rise[a, s], rows.per_whole[a, s], rows.even[a, s]
            part = part_of(f, per_whole, even)
            rest = rows.approach[a, s] - f * (rows.compliance[a, s] + slope * depth)
            rest += rise * spared(even, part)
            for b in range(n):
                if b != a:
                    pulled = rows.pull[a, b, s] * rows.load[b, s]
                    rows.system[a, b, s] = pulled
                    rest -= pulled
            own = compliance_of(rows.compliance[a, s], slope, depth) + rise * per_whole * spared_compliance(even, part)
            rows.system[a, a, s] = own * f
            rows.rest[a, s] = rows.on[a, s] * rest
        invert(rows.order, rows.system, s)
        square = 0.0
        for a in range(n):
            step = 0.0
            for b in range(n):
                step += rows.system[a, b, s] * rows.rest[b, s]
            step = max(step, -0.95)
            rows.load[a, s] += rows.load[a, s] * step
            rows.log[a, s] += log_of_growth(step)
            square += step * step
        rows.step[s] = square
        total += square
    if total > SERIES * SERIES:
        logarithm(rows.load, rows.log, rows.rest)
    return total


@inner(**SUMS)
def _finish(slope, rows):
    """f = 0 where a pair does not carry; marks the lanes whose answer does not hold and returns their number."""
    n, rare = len(rows.order), 0.0
    for s in range(LANES):
        bad = 1.0 if rows.step[s] > CLOSE * CLOSE else 0.0
        for a in range(n):
            rows.load[a, s] *= rows.on[a, s]
            rows.beyond[a, s] = 1.0
        for a in range(n):
            on, x, rise = rows.on[a, s], rows.approach[a, s], rows.rise[a, s]
            left = x + rise
            for b in range(n):
                if b != a:
                    left -= rows.neighbour[a, b, s] * rows.fraction[b, s] * rows.load[b, s]
            bad = 1.0 if on == 0.0 and left > 1e-15 * (abs(x) + rise) else bad
            bad = 1.0 if on * (rows.log[a, s] + 1.0 - rows.offset[a, s]) > 0.0 and slope > 0.0 else bad
        rows.rare[s] = bad
        rare += bad
    return rare


@apart(types.none, FLOAT, VECTOR, INTEGER, INTEGER)
@stored(__file__, entry=False)
def _descend(slope, memory, n, s):
    """Loads of lane s for any number n of pairs, any sign of what neighbours add, any approach; `Rows.memory`."""
    rows = rows_in(memory, 0, memory[:n])
    for a in range(n):
        rows.load[a, s] = 0.0
    for _ in range(1000):
        change = largest = 0.0
        for a in range(n):
            x, before = rows.approach[a, s], rows.load[a, s]
            for b in range(n):
                if b != a:
                    x -= rows.neighbour[a, b, s] * rows.fraction[b, s] * rows.load[b, s]
            f = log = 0.0
            if x + rows.rise[a, s] > 0.0:
                part = rows.rise[a, s], rows.per_whole[a, s], rows.even[a, s]
                f, log = single_load(x, rows.compliance[a, s], slope, rows.offset[a, s], part)
            rows.load[a, s], rows.log[a, s], rows.on[a, s] = f, log, 1.0 if f > 0.0 else 0.0
            rows.beyond[a, s] = exceeded(rows.offset[a, s] - log) if f > 0.0 and slope > 0.0 else 1.0
            change, largest = max(change, abs(f - before)), max(largest, f)
        if change <= 1e-13 * largest:
            break
    couple(rows, s)
