"""One slice of a mesh law, compiled: any number of pairs, any sign of what neighbours add, any load.

The mathematics stands in `fem.contact.evaluation.evaluator`. Each pair of the slice is one column of `work`, its
quantities are the rows of `fem.contact.evaluation.paired_slices`; the compliances c_pq of the pairs p < q and
their slopes stand in the square blocks from row NEIGHBOURS and SLOPES on. Newton on the loaded set; pairs leave at f <=
0 and return at positive approach; coordinate descent, which always converges for a convex function, where that does not
settle.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, types

from fem.contact.evaluation.packing import (
    LANES,
    LEAD,
    MAX_PAIRS,
    NEXT,
    PART,
    PER_STEP,
    PULLS,
    REACH,
    ROWS_PER_BLOCK,
    SHIFT,
    SLICE_ROWS,
    SLOPE,
    Y,
)
from fem.contact.evaluation.paired_slices import (
    COMPLIANCE,
    COMPLIANCE_SLOPE,
    DEPTH,
    DEPTH_SLOPE,
    FRACTION,
    FRACTION_SLOPE,
    GAP_SLOPE,
    LOAD,
    LOG,
    NEVER,
    NUMBER,
    ON,
    PAIR,
    PINION_VARIANT,
    SECOND,
    WHEEL_VARIANT,
    X,
    approach_of,
    damaged,
    fill,
)
from fem.contact.evaluation.single_pair import CLOSE, contact_approach, contact_energy, single_load
from fem.numerics.compiled import FLOAT, INTEGER, MATRIX, PLAIN, VECTOR, apart, stored

REST = ON
NEIGHBOURS = SECOND
SLOPES = NEIGHBOURS + MAX_PAIRS
SYSTEM = SLOPES + MAX_PAIRS
TOTAL = SYSTEM + MAX_PAIRS


@apart(
    types.Tuple((INTEGER, FLOAT, FLOAT, FLOAT, FLOAT)),
    VECTOR, INTEGER, INTEGER, FLOAT, FLOAT, FLOAT, MATRIX, INTEGER, VECTOR, MATRIX,
)  # fmt: skip
@stored(__file__)
def solve_slice(tables, block, lane, own_cycle, delta, psi, near, n_near, relief, work):
    """Solve one slice; returns its number of pairs and, per unit width, load, stiffness, energy, d(energy)/d xi.

    relief (n_near,) m is taken off the approach of each near pair.
    """
    n = _gather(tables, block, lane, own_cycle, delta, psi, near, n_near, relief, work)
    slope = tables[SLOPE]
    _loads(n, slope, work)
    load = stiffness = energy = rate = 0.0
    for p in range(n):
        work[REST, p] = 1.0
        work[SYSTEM + p, p] = work[COMPLIANCE, p] + slope * max(work[DEPTH, p] - work[LOG, p] - 1.0, 0.0)
    _solve_system(n, work)
    for p in range(n):
        f, phi = work[LOAD, p], work[FRACTION, p]
        stiffness += phi * work[REST, p]
        load += phi * f
        if f > 0.0:
            stored, by_depth = contact_energy(f, work[LOG, p], slope, work[DEPTH, p]) if slope > 0.0 else (0.0, 0.0)
            own = work[X, p] * f - 0.5 * work[COMPLIANCE, p] * f * f - stored
            energy += phi * own
            rate += work[FRACTION_SLOPE, p] * own
            rate -= phi * (f * work[GAP_SLOPE, p] + 0.5 * f * f * work[COMPLIANCE_SLOPE, p])
            rate -= phi * by_depth * work[DEPTH_SLOPE, p]
        for q in range(p + 1, n):
            both, other, value = f * work[LOAD, q], work[FRACTION, q], work[NEIGHBOURS + p, q]
            energy -= value * phi * other * both
            rate -= value * (work[FRACTION_SLOPE, p] * other + phi * work[FRACTION_SLOPE, q]) * both
            rate -= work[SLOPES + p, q] * phi * other * both
    return n, load, stiffness, energy, rate


@njit(**PLAIN)
def _gather(tables, block, lane, own_cycle, delta, psi, near, n_near, relief, work):
    """Columns of the pairs of one slice, in rising order of p; returns their number."""
    base = SLICE_ROWS + block * ROWS_PER_BLOCK * LANES + lane
    here = own_cycle + tables[base + SHIFT * LANES]
    approach = delta + psi * tables[base + Y * LANES] - tables[base + LEAD * LANES]
    reach, per_step = int(tables[REACH]), tables[PER_STEP]
    lowest = NEVER if tables[PULLS] != 0.0 else 0.0
    cells, inside = np.empty(MAX_PAIRS, np.int64), np.empty(MAX_PAIRS)
    n, first = np.int64(0), np.int64(0)  # plain numbers: a literal is a type of its own, compiled for itself
    for m in range(n_near):
        x, k, u = approach_of(tables, here, approach, tables[base + PART * LANES], near, m)
        x -= relief[m]
        if not x > lowest:
            continue
        fill(tables, first, n, x, k, u, here, near, m, work)
        if near[m, PINION_VARIANT] != 0.0 or near[m, WHEEL_VARIANT] != 0.0:
            x = damaged(tables, block * LANES + lane, first, n, x, k, u, near, m, work)
        if not x > lowest:
            continue
        cells[n], inside[n] = k, u
        work[NEIGHBOURS + n, n] = 0.0
        for a in range(n):
            apart = int(near[m, NUMBER] - work[PAIR, a])
            value = steep = 0.0
            if apart <= reach:
                k = cells[a] + NEXT + 2 * (apart - 1)
                value, steep = tables[k] + inside[a] * tables[k + 1], tables[k + 1] * per_step
            work[NEIGHBOURS + a, n] = work[NEIGHBOURS + n, a] = value
            work[SLOPES + a, n] = steep
        n += 1
        if n == MAX_PAIRS:
            break
    return n


@njit(**PLAIN)
def slice_stiffness(n, slope, work, stiffness):
    """d(phi_p f_p) / d(approach of pair q) of a solved slice, into stiffness (n, n)."""
    for q in range(n):
        for p in range(n):
            work[REST, p] = 1.0 if p == q else 0.0
            work[SYSTEM + p, p] = work[COMPLIANCE, p] + slope * max(work[DEPTH, p] - work[LOG, p] - 1.0, 0.0)
        _solve_system(n, work)
        for p in range(n):
            stiffness[p, q] = work[FRACTION, p] * work[REST, p]


@njit(**PLAIN)
def _relieved(n, p, work):
    """Approach left to pair p itself: x_p - sum_q c_pq phi_q f_q."""
    x = work[X, p]
    for q in range(n):
        x -= work[NEIGHBOURS + p, q] * work[FRACTION, q] * work[LOAD, q]
    return x


@njit(**PLAIN)
def _solve_system(n, work):
    """(diag(D) + c phi) d = rest over the loaded pairs (f > 0), in place of rest; 0 for the others.

    D stands on the diagonal of the system rows already.
    """
    for p in range(n):
        loaded = work[LOAD, p] > 0.0
        for q in range(n):
            if q != p:
                both = loaded and work[LOAD, q] > 0.0
                work[SYSTEM + p, q] = work[NEIGHBOURS + p, q] * work[FRACTION, q] if both else 0.0
        if not loaded:
            work[SYSTEM + p, p] = 1.0
            work[REST, p] = 0.0
    for p in range(n):
        for q in range(p + 1, n):
            factor = work[SYSTEM + q, p] / work[SYSTEM + p, p]
            if factor != 0.0:
                for r in range(p + 1, n):
                    work[SYSTEM + q, r] -= factor * work[SYSTEM + p, r]
                work[REST, q] -= factor * work[REST, p]
    for p in range(n - 1, -1, -1):
        for q in range(p + 1, n):
            work[REST, p] -= work[SYSTEM + p, q] * work[REST, q]
        work[REST, p] /= work[SYSTEM + p, p]


@njit(**PLAIN)
def _loads(n, slope, work):
    """Line loads of the gathered pairs."""
    for p in range(n):
        _alone(p, work[X, p], slope, work)
    for _ in range(40):
        for p in range(n):
            f = work[LOAD, p]
            if f > 0.0:
                own, rate = contact_approach(f, work[LOG, p], slope, work[DEPTH, p]) if slope > 0.0 else (0.0, 0.0)
                work[REST, p] = _relieved(n, p, work) - work[COMPLIANCE, p] * f - own
                work[SYSTEM + p, p] = work[COMPLIANCE, p] + rate
        _solve_system(n, work)
        largest = 0.0
        switched = False
        for p in range(n):
            f = work[LOAD, p]
            if f > 0.0:
                step = work[REST, p] / f
                largest = max(largest, abs(step))
                if step <= -1.0:
                    switched = True
                    step = -0.9 if slope > 0.0 and _relieved(n, p, work) > 0.0 else -1.0
                work[LOAD, p] = f * (1.0 + step)
                if slope > 0.0 and step > -1.0:
                    work[LOG, p] = work[LOG, p] + step if abs(step) <= CLOSE else math.log(work[LOAD, p])
        if switched or largest > CLOSE:
            continue
        for p in range(n):
            if work[LOAD, p] == 0.0:
                x = _relieved(n, p, work)
                if x > 1e-15 * abs(work[X, p]):
                    _alone(p, x, slope, work)
                    switched = True
        if not switched:
            return
    for _ in range(1000):
        change = largest = 0.0
        for p in range(n):
            before = work[LOAD, p]
            _alone(p, _relieved(n, p, work), slope, work)
            change, largest = max(change, abs(work[LOAD, p] - before)), max(largest, work[LOAD, p])
        if change <= 1e-14 * largest:
            return


@njit(**PLAIN)
def _alone(p, x, slope, work):
    """Load of pair p by itself at the approach x."""
    work[LOAD, p] = work[LOG, p] = 0.0
    if x > 0.0:
        work[LOAD, p], work[LOG, p] = single_load(x, work[COMPLIANCE, p], slope, work[DEPTH, p])
