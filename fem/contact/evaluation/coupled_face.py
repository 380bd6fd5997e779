"""Mesh laws whose slices are coupled along the face, compiled: tooth bending that spreads, wind-up and tilt of bodies.

With the slice potentials U_s, convex in the approach of each pair, the law of `fem.contact.law` is the minimum of

    sum_s w_s U_s(x_s - g v_s - d - t y_s) + v' T v / 2 + (d, t) E^-1 (d, t)' / 2,   g = sqrt(D)

over the fields v_p (one per pair) and the body displacements d, t; E = [E_0 E_01; E_01 E_1], and T stands for
1 - a^2 d^2/dy^2 between the slices
(diagonal w_s, springs a^2 / distance between neighbours, nothing beyond the ends). All parts are convex, so the minimum
is unique and U stays convex in (delta, psi). Newton's method: the stiffnesses
K_s = phi J^-1 of the slices enter

    (T + w g K g) dv = w g phi f - T v - w g K 1 (dd + dt y)

which is tridiagonal in blocks of the pairs; d and t are coupled with everything. F, M, U and all derivatives are those
of the minimum (envelope theorem); the total stiffness is the slices' with fields and bodies in series.

Slices of at most two pairs go through `fem.contact.evaluation.coupled_newton`, where loads, fields and bodies move at
once; Hertz contacts bend little, so three or four steps reach round-off. Where that does not settle, or a slice is not
of that kind, the slices are solved one by one (`fem.contact.evaluation.coupled_slices`). Bodies that tilt can bring
pairs into contact that the free approach leaves open; the candidates are then collected anew for an approach wide
enough, and the answer is checked against it.

Measured on the stage 1 pair of the shipped rig (15 slices, two pairs, start values without history; one core of an AMD
EPYC, 3 GHz class): 2.6 us per call in 3.8 steps, two states at one cycle 3.8 us; for independent slices 0.83 us.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit, types

from fem.contact.evaluation import coupled_newton, field_elimination, paired_slices
from fem.contact.evaluation.candidate_pairs import pairs_near
from fem.contact.evaluation.coupled_newton import TOTAL
from fem.contact.evaluation.coupled_slices import evaluate_in_turn
from fem.contact.evaluation.packing import (
    BLOCKS,
    LANES,
    LARGEST_NEAR,
    LENGTH,
    OFFSET,
    PULLS,
    ROWS_PER_BLOCK,
    SIGN,
    SLICE_ROWS,
    SLICES,
    WIDTH,
    Y,
)
from fem.numerics.compiled import FLOAT, INTEGER, MATRIX, PLAIN, VECTOR, apart, stored

_inline: dict[str, Any] = {"forceinline": True, "fastmath": {"contract"}}


@apart(types.UniTuple(FLOAT, 14), VECTOR, FLOAT, types.UniTuple(FLOAT, 4), INTEGER, MATRIX, MATRIX, VECTOR)
@stored(__file__)
def evaluate_coupled(tables, cycle, states, count, pinion, wheel, pair_force):
    """F, M, U, dF/d delta, dF/d psi, dM/d psi, dU/dc of a law with coupled slices, at `count` states (1, 2).

    states (delta, psi, delta_0, psi_0); the seven numbers of the second state follow those of the first in the answer
    (14,). Each pair's force is added to pair_force[p - floor(c') + size // 2] where that exists.
    """
    own_cycle = tables[SIGN] * cycle + tables[OFFSET]
    blocks, n_s, top = int(tables[BLOCKS]), int(tables[SLICES]), int(tables[BLOCKS]) * TOTAL
    work = np.empty((top + LARGEST_NEAR // 2 + 1, LANES))
    bits, answer = work.view(np.int64), work[top + LARGEST_NEAR // 2]
    answer[:] = 0.0
    near = work[top : top + LARGEST_NEAR // 2].reshape((LARGEST_NEAR, 8))
    n_near = pairs_near(tables, own_cycle, pinion, wheel, near)
    done, retry, fresh, warm = 0 if n_near > 0 else count, False, True, 0
    usual, touched, wide = True, False, states
    while done < count:
        if fresh:
            usual, touched, fresh, warm = tables[PULLS] == 0.0, False, False, 0
            for k in range(blocks):
                rows = work[k * TOTAL : (k + 1) * TOTAL]
                touches = paired_slices.gather(tables, k, own_cycle, wide, near, n_near, rows)
                touched = touched or touches
                rare = 0.0
                for s in range(LANES):
                    rare += rows[paired_slices.RARE, s]
                usual = usual and rare == 0.0
                usual = usual and coupled_newton.prepare(tables, k, own_cycle, rows)
            if usual and touched and tables[LENGTH] > 0.0:
                usual = coupled_newton.link(tables, n_s, work)
        if touched:
            settled, good, d, t = False, False, 0.0, 0.0
            if usual:
                which = 0 if retry else done
                settled, d, t = settle(tables, blocks, n_s, wide, which, warm > 0, work, bits, answer, done)
                good = settled and covered(tables, n_s, wide, which, d, t)
            if settled and not good and not retry:
                delta, psi = states[2 * done], states[2 * done + 1]
                wide, retry, fresh = (delta, psi, delta - 2.0 * d, psi - 2.0 * t), True, True
                continue
            warm = 1 if good else 0
            if not good:
                delta, psi = states[2 * done], states[2 * done + 1]
                found = evaluate_in_turn(tables, own_cycle, delta, psi, near, n_near, pair_force)
                for i in range(7):
                    answer[7 * done + i] = found[i]
            elif pair_force.size > 0:
                add_forces(tables, n_s, math.floor(own_cycle), work, pair_force)
        if retry:
            wide, retry, fresh = states, False, True
        done += 1
    a, sign = answer, tables[SIGN]
    first = a[0], a[1], a[2], a[3], a[4], a[5], sign * a[6]
    return first + (a[7], a[8], a[9], a[10], a[11], a[12], sign * a[13])


@njit(**PLAIN, **_inline)
def settle(tables, blocks, n_s, states, which, warm, work, bits, answer, done):
    """Newton iteration from scratch or from the loads there are; fills the answer. True if it holds, and d, t."""
    d = t = k00 = k01 = k11 = force = moment = stiff = mixed = tilt = 0.0
    for k in range(blocks):
        rows, row_bits = work[k * TOTAL : (k + 1) * TOTAL], bits[k * TOTAL : (k + 1) * TOTAL]
        coupled_newton.take_state(tables, k, states, which, rows)
        if warm:
            coupled_newton.resume(rows)
        else:
            f, m, a, b, c = coupled_newton.estimate(tables, k, rows, row_bits)
            force, moment, stiff, mixed, tilt = force + f, moment + m, stiff + a, mixed + b, tilt + c
    if not warm:
        d, t, _, _, _ = field_elimination.in_series(tables, stiff, mixed, tilt, force, moment)
        for k in range(blocks):
            coupled_newton.start(tables, k, d, t, work[k * TOTAL : (k + 1) * TOTAL], bits[k * TOTAL : (k + 1) * TOTAL])
    settled = False
    for _ in range(coupled_newton.STEPS):
        force = moment = stiff = mixed = tilt = 0.0
        for k in range(blocks):
            f, m, a, b, c = coupled_newton.linearise(tables, k, work[k * TOTAL : (k + 1) * TOTAL])
            force, moment, stiff, mixed, tilt = force + f, moment + m, stiff + a, mixed + b, tilt + c
        if tables[LENGTH] > 0.0:
            t0, t1, t2, t3, t4 = field_elimination.eliminate(tables, n_s, work)
            force, moment, stiff, mixed, tilt = force - t0, moment - t1, stiff - t2, mixed - t3, tilt - t4
        d, t, k00, k01, k11 = field_elimination.in_series(tables, stiff, mixed, tilt, force, moment)
        if tables[LENGTH] > 0.0:
            field_elimination.substitute(n_s, d, t, work)
        load = error = total = 0.0
        for k in range(blocks):
            rows, row_bits = work[k * TOTAL : (k + 1) * TOTAL], bits[k * TOTAL : (k + 1) * TOTAL]
            f, a, b = coupled_newton.advance(tables, k, d, t, rows, row_bits)
            load, error, total = load + f, error + a, total + b
        settled = total < 1.0 and error <= coupled_newton.CLOSE * load
        if settled:
            break
    force = moment = energy = rate = beyond = 0.0
    for k in range(blocks):
        rows = work[k * TOTAL : (k + 1) * TOTAL]
        held, along, far = coupled_newton.finish(tables, k, rows)
        f, m, u, _, _, _, r = paired_slices.block_sums(tables, k, rows)
        force, moment, beyond = force + f, moment + m, beyond + far
        energy, rate = energy + u + 0.5 * held, rate + r - along
    at = 7 * done
    answer[at], answer[at + 1], answer[at + 2] = force, moment, energy + 0.5 * (d * force + t * moment)
    answer[at + 3], answer[at + 4], answer[at + 5], answer[at + 6] = k00, k01, k11, rate
    return settled and beyond == 0.0, d, t


@njit(**PLAIN, **_inline)
def covered(tables, n_s, states, which, d, t):
    """True if no slice approaches further than the states for which the pairs were collected."""
    for s in range(n_s):
        y = tables[SLICE_ROWS + ((s // LANES) * ROWS_PER_BLOCK + Y) * LANES + s % LANES]
        own = states[2 * which] + states[2 * which + 1] * y
        room = paired_slices.largest_approach(states, y) - own + 1e-14 * abs(own)  # of rounding, where nothing moves
        if -(d + t * y) > room:
            return False
    return True


@njit(**PLAIN)
def add_forces(tables, n_s, anchor, work, pair_force):
    """Forces of the pairs of a settled state."""
    for s in range(n_s):
        top, lane = (s // LANES) * TOTAL, s % LANES
        w = tables[SLICE_ROWS + ((s // LANES) * ROWS_PER_BLOCK + WIDTH) * LANES + lane]
        for at in (top, top + paired_slices.SECOND):
            if work[at + paired_slices.LOAD, lane] > 0.0:
                place = int(work[at + paired_slices.PAIR, lane]) - anchor + pair_force.size // 2
                if 0 <= place < pair_force.size:
                    pair_force[place] += (
                        w * work[at + paired_slices.FRACTION, lane] * work[at + paired_slices.LOAD, lane]
                    )
