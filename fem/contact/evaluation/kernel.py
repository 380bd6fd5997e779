"""Compiled door to the mesh law: one state in, forces, energy and their derivatives out.

`tables` is the array of `fem.contact.evaluation.packing.pack`, `pinion` and `wheel` the tooth terms of
`fem.contact.teeth`. The mathematics stands in `fem.contact.evaluation.evaluator`; sixteen usual slices at a time are
solved in `fem.contact.evaluation.paired_slices`, the others one by one in `fem.contact.evaluation.general_slices`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, types

from fem.contact.evaluation import general_slices, paired_slices
from fem.contact.evaluation.candidate_pairs import pairs_near
from fem.contact.evaluation.coupled_face import evaluate_coupled
from fem.contact.evaluation.packing import (
    BLOCKS,
    COUPLED,
    LANES,
    LARGEST_NEAR,
    OFFSET,
    ROWS_PER_BLOCK,
    SIGN,
    SLICE_ROWS,
    SLOPE,
    WIDTH,
    Y,
)
from fem.numerics.compiled import FLOAT, INTEGER, MATRIX, PLAIN, VECTOR, apart, stored


@njit(**PLAIN, forceinline=True)
def settle(slope, work, bits):
    """Newton sweeps of a block until they settle; returns the number of rare slices."""
    for _ in range(paired_slices.SWEEPS):
        if paired_slices.sweep(slope, work, bits) <= paired_slices.CLOSE * paired_slices.CLOSE:
            break
    return paired_slices.switch_off(slope, work)


@apart(types.UniTuple(FLOAT, 14), VECTOR, FLOAT, types.UniTuple(FLOAT, 4), INTEGER, MATRIX, MATRIX, VECTOR)
@stored(__file__)
def evaluate_uncoupled(tables, cycle, states, count, pinion, wheel, pair_force):
    """What `evaluate_coupled` returns, of a law whose slices are not coupled along the face.

    The tables are read once, and the second Newton iteration starts from the line loads of the first.
    """
    own_cycle, sign = tables[SIGN] * cycle + tables[OFFSET], tables[SIGN]
    work = np.empty((paired_slices.TOTAL + LARGEST_NEAR // 2 + 1, LANES))
    bits, answer = work.view(np.int64), work[paired_slices.TOTAL + LARGEST_NEAR // 2]
    for i in range(LANES):
        answer[i] = 0.0
    near = work[paired_slices.TOTAL : paired_slices.TOTAL + LARGEST_NEAR // 2].reshape((LARGEST_NEAR, 8))
    n_near = pairs_near(tables, own_cycle, pinion, wheel, near)
    slope = tables[SLOPE]
    for block in range(int(tables[BLOCKS])):
        if not paired_slices.gather(tables, block, own_cycle, states, near, n_near, work):
            continue
        paired_slices.take_state(tables, block, states, -1, 0, work)
        paired_slices.guess(slope, work, bits)
        solve_block(tables, block, own_cycle, states, 0, near, n_near, work, bits, pair_force, answer)
        if count > 1:
            paired_slices.take_state(tables, block, states, 0, 1, work)
            solve_block(tables, block, own_cycle, states, 1, near, n_near, work, bits, pair_force, answer)
    a = answer
    first = a[0], a[1], a[2], a[3], a[4], a[5], sign * a[6]
    return first + (a[7], a[8], a[9], a[10], a[11], a[12], sign * a[13])


@njit(**PLAIN, forceinline=True)
def solve_block(tables, block, own_cycle, states, which, near, n_near, work, bits, pair_force, answer):
    """Add the seven sums of a block at one state to the answer, and its forces to pair_force if that is not empty."""
    rare = settle(tables[SLOPE], work, bits)
    add_to(answer, 7 * which, paired_slices.block_sums(tables, block, work))
    if pair_force.size > 0:
        add_shares(tables, block, math.floor(own_cycle), work, pair_force)
    if rare > 0.0:
        delta, psi = states[2 * which], states[2 * which + 1]
        add_to(answer, 7 * which, rare_sums(tables, block, own_cycle, delta, psi, near, n_near, work, pair_force))


@njit(**PLAIN, forceinline=True)
def add_to(answer, at, sums):
    """Add the seven sums of a block."""
    for i in range(7):
        answer[at + i] += sums[i]


@njit(**PLAIN)
def respond(tables, cycle, states, count, pinion, wheel, pair_force):
    """Answer (14,) at `count` states (1, 2), see `fem.contact.evaluation.coupled_face.evaluate_coupled`."""
    if tables[COUPLED] > 0.0:
        return evaluate_coupled(tables, cycle, states, count, pinion, wheel, pair_force)
    return evaluate_uncoupled(tables, cycle, states, count, pinion, wheel, pair_force)


@njit(**PLAIN)
def add_shares(tables, block, anchor, work, pair_force):
    """Forces of the pairs in the slices that are not rare."""
    base = SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    for s in range(LANES):
        for at in (0, paired_slices.SECOND):
            force = (
                tables[base + WIDTH * LANES + s]
                * work[at + paired_slices.FRACTION, s]
                * work[at + paired_slices.LOAD, s]
            )
            if force > 0.0 and work[paired_slices.RARE, s] == 0.0:
                place = int(work[at + paired_slices.PAIR, s]) - anchor + pair_force.size // 2
                if 0 <= place < pair_force.size:
                    pair_force[place] += force


@njit(**PLAIN)
def rare_sums(tables, block, own_cycle, delta, psi, near, n_near, work, pair_force):
    """The sums of the slices that `paired_slices` left over, and their shares."""
    force = moment = energy = k = mixed = tilt = rate = 0.0
    base = SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    own, none = np.empty((general_slices.TOTAL, general_slices.MAX_PAIRS)), np.zeros(LARGEST_NEAR)
    for s in range(LANES):
        if work[paired_slices.RARE, s] == 0.0:
            continue
        y, w = tables[base + Y * LANES + s], tables[base + WIDTH * LANES + s]
        n, load, stiff, stored, along = general_slices.solve_slice(
            tables, block, s, own_cycle, delta, psi, near, n_near, none, own
        )
        force, moment, energy, rate = force + w * load, moment + w * load * y, energy + w * stored, rate + w * along
        k, mixed, tilt = k + w * stiff, mixed + w * stiff * y, tilt + w * stiff * y * y
        for p in range(n if pair_force.size > 0 else 0):
            place = int(own[paired_slices.PAIR, p]) - math.floor(own_cycle) + pair_force.size // 2
            if 0 <= place < pair_force.size:
                pair_force[place] += w * own[paired_slices.FRACTION, p] * own[paired_slices.LOAD, p]
    return force, moment, energy, k, mixed, tilt, rate


@stored(__file__)
def evaluate(tables, cycle, delta, psi, pinion, wheel):
    """Response of one flank at one state.

    Parameters
    ----------
    tables : (n,), from `law_tables`
    cycle : mesh cycle c of the gears (1); the law turns it into its own c'
    delta, psi : approach along the transverse line of action (m) and tilt (rad)
    pinion (z1, 6), wheel (z2, 6) : tooth terms, see `fem.contact.teeth`

    Returns
    -------
    F (N), M (N m), U (J), dF/d delta (N/m), dF/d psi = dM/d delta (N), dM/d psi (N m), dU/dc (J)
    """
    return respond(tables, cycle, (delta, psi, delta, psi), np.int64(1), pinion, wheel, np.empty(0))[:7]


@stored(__file__)
def evaluate_two(tables, cycle, delta, psi, delta_0, psi_0, pinion, wheel):
    """Responses at (delta, psi) and at (delta_0, psi_0), both at the same cycle, without dU/dc.

    The tables are read once and the second Newton iteration starts from the line loads of the first.

    Returns
    -------
    F, M, U, dF/d delta, dF/d psi, dM/d psi of the first state, then the same of the second
    """
    found = respond(tables, cycle, (delta, psi, delta_0, psi_0), np.int64(2), pinion, wheel, np.empty(0))
    return found[:6] + found[7:13]


@stored(__file__)
def evaluate_shares(tables, cycle, delta, psi, pinion, wheel, pair_force):
    """As `evaluate`, and add the force (N) of pair p to pair_force[p - floor(c') + pair_force.size // 2].

    c' = cycle_sign c + cycle_offset. Pairs outside the array are left out; 2 `share_reach` + 1 places hold all.
    """
    return respond(tables, cycle, (delta, psi, delta, psi), np.int64(1), pinion, wheel, pair_force)[:7]


@stored(__file__)
def evaluate_many(tables, cycle, delta, psi, pinion, wheel, out):
    """Rows of `evaluate` for states given as arrays (n,), into out (n, 7)."""
    none = np.empty(0)
    for i in range(cycle.size):
        state = (delta[i], psi[i], delta[i], psi[i])
        found = respond(tables, cycle[i], state, np.int64(1), pinion, wheel, none)
        for j in range(7):
            out[i, j] = found[j]
