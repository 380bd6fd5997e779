"""Mesh laws near a tooth whose damage adds compliance by modes, compiled: slices, fields, bodies and modes in series.

To the minimum of `fem.contact.evaluation.coupled_face` every mode k adds an unknown q_k,

    ... U_s(x - g v - d - t y - sum_k m_k q_k) ... + sum_k q_k^2 / 2,

so that q_k = sum w phi m_k f. It enters like the bodies d and t, but by a displacement m_k that differs from pair to
pair. With K of the slices and A = T + w g K g of the fields, displacements c_0 = 1, c_1 = y, c_2 ... = m_k find

    k_ij = sum w c_i K c_j - b_i' A^-1 b_j,    b_i = w g K c_i,

and (d, t, q) = E (h - k (d, t, q)) with E = diag(E_bodies, 1) and h the loads at rest. The potential stays convex, and
F, M, U and their derivatives stay those of the minimum. Sound teeth do not come here.

A mode may lift a tooth at one end where it is loaded at the other, so pairs that come near without touching are
collected, too, and the answer is checked against what was collected. What does not settle, slices of more than three
pairs and neighbours that pull are solved by `settle_exactly`, with all pairs within reach as candidates: the slices
exactly, at fixed fields, bodies and modes, then those by a Newton step, in turn. It solves every law: without modes a
coupled face, without modes, fields and bodies independent slices.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit, types

from fem.contact.evaluation.coupled_newton import CLOSE, STEPS, advance, finish, guess
from fem.contact.evaluation.coupled_system import face_sums, linearise, take_state
from fem.contact.evaluation.fields import block_rows, eliminate, face_room, field_rows, gather_face, substitute
from fem.contact.evaluation.law_tables import LANES, LARGEST_NEAR, slices_of, unpacked
from fem.contact.evaluation.near_pairs import NEAR_ROOM, damaged_teeth, near_pairs
from fem.contact.evaluation.slice_loads import solve_slices
from fem.contact.evaluation.slice_rows import NEVER, STATES, cell_of, state_alone
from fem.contact.evaluation.slice_sums import ANSWER, keep_loads, totals
from fem.numerics.compiled import INLINE, MATRIX, SPREAD, VECTOR, apart, inner, stored

EXACT_STEPS = 40
EXACT_CLOSE = 1e-11  # step of the fields, relative to the largest, at which the loads found before it are taken
ASIDE = 0.25  # of the approach: pairs this far apart are collected, for modes that lift a tooth towards its mate


class Modes(NamedTuple):
    """The modes of the damaged teeth near mesh; arrays (mode, ...)."""

    teeth: np.ndarray  # (tooth, 3) pair of the damaged tooth, 0 pinion or 1 wheel, variant
    share: np.ndarray  # q, (N m)^(1/2)
    value: np.ndarray  # (mode, block, row, lane) m_k, (m/N)^(1/2)
    slope: np.ndarray  # by xi
    right: np.ndarray  # b_k while the slices nearer the middle are held
    answer: np.ndarray  # their parts of A^-1 b_k
    stiffness: np.ndarray  # (i, j) k of d, t and the modes
    force: np.ndarray  # (i,) h
    system: np.ndarray  # (i, i + 3)


@apart(ANSWER, VECTOR, STATES, MATRIX, MATRIX, MATRIX)
@stored(__file__, entry=False)
def evaluate_damaged(packed, states, pinion, wheel, loads):
    """As `coupled_face.evaluate_coupled`, near teeth with modes.

    Parameters
    ----------
    packed, states, pinion, wheel, loads : those of `coupled_face.evaluate_coupled`
    """
    law, answer = unpacked(packed), np.zeros(14)
    for which in range(states.asked):
        alone = state_alone(states, which)
        own = answer[7 * which : 7 * which + 7]
        good = False
        if law.pulls == 0.0:
            good = _settle(packed, alone, pinion, wheel, loads, own)
        if not good:
            settle_exactly(packed, alone, pinion, wheel, loads, own)
    return totals(answer, law.sign)


@apart(types.boolean, VECTOR, STATES, MATRIX, MATRIX, MATRIX, VECTOR)
@stored(__file__, entry=False)
def _settle(packed, states, pinion, wheel, loads, answer):
    """Newton's method on slices, fields, bodies and modes at once; the seven numbers of a single state, if it holds."""
    law = unpacked(packed)
    own_cycle = law.sign * states.cycle + law.offset
    teeth, numbers = np.empty(NEAR_ROOM), np.empty(face_room(len(law.block), 3))
    near, memory = near_pairs(law, own_cycle, pinion, wheel, teeth), (numbers, 0, (0, 1, 2))
    aside = ASIDE * (abs(states.delta) + abs(states.psi * law.block[0, 0, 0]))
    found = gather_face(law, near, own_cycle, states, -aside, memory)
    modes = _gather_modes(law, own_cycle, pinion, wheel, memory)
    settled, d, t = False, 0.0, 0.0
    if found == 3:
        settled, d, t = _solve(law, states, modes, memory, answer)
        settled = settled and _least_move(law, own_cycle, d, t, modes) >= -aside
        if settled and loads.size > 0:
            keep_all_loads(law, own_cycle, memory, loads)
    numbers[0] = teeth[0] = 0.0  # views of them were lent
    return settled or found == 0


@apart(types.none, VECTOR, STATES, MATRIX, MATRIX, MATRIX, VECTOR)
@stored(__file__, entry=False)
def settle_exactly(packed, states, pinion, wheel, loads, answer):
    """The seven numbers of a single state by exact slices of any number of pairs, for every law: with or without
    fields, bodies and modes.

    Parameters
    ----------
    packed, pinion, wheel, loads : those of `coupled_face.evaluate_coupled`
    states : `States`, a single state
    answer : (7,) out: as in `coupled_system.face_sums`; left as it is where no pair is within reach
    """
    law, n, found = unpacked(packed), 1, 2
    own_cycle = law.sign * states.cycle + law.offset
    teeth, numbers = np.empty(NEAR_ROOM), np.empty(0)
    near = near_pairs(law, own_cycle, pinion, wheel, teeth)
    while found > n:
        n += 1
        numbers = np.empty(face_room(len(law.block), n))
        found = gather_face(law, near, own_cycle, states, NEVER, (numbers, 0, numbers[:n]))
    if found == n:
        memory = (numbers, 0, numbers[:n])
        modes = _gather_modes(law, own_cycle, pinion, wheel, memory)
        _solve_in_turn(law, states, modes, memory, answer)
        if loads.size > 0:
            keep_all_loads(law, own_cycle, memory, loads)
        numbers[0] = teeth[0] = 0.0  # views of them were lent


@njit(**SPREAD)
def _gather_modes(law, own_cycle, pinion, wheel, memory):
    """`Modes` at the pairs of a gathered face."""
    teeth = np.empty((2 * LARGEST_NEAR, 3))
    teeth = teeth[: damaged_teeth(law, own_cycle, pinion, wheel, teeth)]
    count, n, blocks = 0, len(memory[2]), len(law.block)
    for i in range(len(teeth)):
        count += int(law.pinion_modes if teeth[i, 1] == 0.0 else law.wheel_modes)
    arrays = np.zeros((4, count, blocks, n, LANES))
    modes = Modes(
        teeth,
        np.zeros(count),
        arrays[0],
        arrays[1],
        arrays[2],
        arrays[3],
        np.zeros((2 + count, 2 + count)),
        np.zeros(2 + count),
        np.zeros((2 + count, 5 + count)),
    )
    for block in range(blocks):
        rows = block_rows(memory, block)
        for a in range(n):
            for s in range(LANES):
                if rows.approach[a, s] > NEVER:
                    cell, u = cell_of(law, rows.place[a, s])
                    at = 0
                    for i in range(len(teeth)):
                        table = law.pinion_mode if teeth[i, 1] == 0.0 else law.wheel_mode
                        side = int(rows.pair[a, s] - teeth[i, 0]) + 1
                        for k in range(table.shape[4]):
                            if 0 <= side <= 2:
                                here = table[int(teeth[i, 2]) - 1, side, block * LANES + s]
                                change = here[cell + 1, k] - here[cell, k]
                                modes.value[at + k, block, a, s] = here[cell, k] + u * change
                                modes.slope[at + k, block, a, s] = change * law.per_step
                        at += table.shape[4]
    return modes


@njit(**SPREAD)
def _solve(law, states, modes, memory, answer):
    """Loads from scratch, as `coupled_newton.solve_face`: True if they hold, and d, t."""
    d = t = 0.0
    settled, stiffness = False, (0.0, 0.0, 0.0)
    take_state(law, states, 0, memory)
    for block in range(len(law.block)):
        guess(law.slope, block_rows(memory, block), field_rows(memory, block))
    for _ in range(STEPS):
        d, t, stiffness = _newton_step(law, modes, memory)
        load = error = square = 0.0
        for block in range(len(law.block)):
            rows, fields = block_rows(memory, block), field_rows(memory, block)
            _shift(1.0, modes, block, fields)
            sums = advance(law.slope, d, t, rows, fields)
            _shift(-1.0, modes, block, fields)
            load, error, square = load + sums[0], error + sums[1], square + sums[2]
        settled = square < 1.0 and error <= CLOSE * load
        if settled:
            break
    beyond = 0.0
    for block in range(len(law.block)):
        beyond += finish(law.slope, block_rows(memory, block))
    face_sums(law, d, t, stiffness, memory, answer)
    _add_modes(modes, memory, answer)
    return settled and beyond == 0.0, d, t


@njit(**SPREAD)
def _solve_in_turn(law, states, modes, memory, answer):
    """Slices exactly at fixed fields, bodies and modes, then those by a Newton step, in turn; halved steps later."""
    d = t = scale = 0.0
    stiffness = (0.0, 0.0, 0.0)
    take_state(law, states, 0, memory)
    for step in range(EXACT_STEPS):
        before = modes.share.copy()
        for block in range(len(law.block)):
            rows, fields = block_rows(memory, block), field_rows(memory, block)
            _shift(1.0, modes, block, fields)
            _relieve(d, t, rows, fields)
            _shift(-1.0, modes, block, fields)
            solve_slices(law.slope, True, rows)
        new_d, new_t, stiffness = _newton_step(law, modes, memory)
        largest = abs(new_d - d) + abs(new_t - t) * abs(block_rows(memory, 0).y[0])
        for block in range(len(law.block)):
            largest = max(largest, _largest_move(field_rows(memory, block)))
        for k in range(len(before)):
            largest = max(largest, abs(modes.share[k] - before[k]) * np.abs(modes.value[k]).max())
        scale = max(scale, largest)
        part = 1.0 if step < 8 or largest <= 1e-3 * scale else 0.5
        d, t = d + part * (new_d - d), t + part * (new_t - t)
        for k in range(len(before)):
            modes.share[k] = before[k] + part * (modes.share[k] - before[k])
        for block in range(len(law.block)):
            _move_fields(part, field_rows(memory, block))
        if largest <= EXACT_CLOSE * scale:
            break
    face_sums(law, d, t, stiffness, memory, answer)
    _add_modes(modes, memory, answer)


@njit(**SPREAD)
def keep_all_loads(law, own_cycle, memory, loads):
    """Line loads of all blocks, as in `keep_loads`.

    Parameters
    ----------
    law, own_cycle, memory : as for `fields.gather_face`
    loads : (place, slice) out, N/m
    """
    for block in range(len(law.block)):
        keep_loads(block_rows(memory, block), block, math.floor(own_cycle), loads)


@inner(**INLINE)
def _relieve(d, t, rows, fields):
    """The approaches that fields and body displacements leave to the slices of a block.

    Parameters
    ----------
    d, t : body displacements, m and rad
    rows, fields : `Rows`, out, and `FieldRows` of the block
    """
    for a in range(len(rows.order)):
        for s in range(LANES):
            taken = d + t * rows.y[s] + fields.gain[a, s] * fields.field[a, s]
            rows.approach[a, s] = fields.free[a, s] - taken
            fields.before[a, s] = fields.field[a, s]


@inner(**INLINE)
def _largest_move(fields):
    """The largest |g dv| of a step of the fields, m."""
    largest = 0.0
    for a in range(len(fields.order)):
        for s in range(LANES):
            largest = max(largest, abs(fields.gain[a, s] * (fields.field[a, s] - fields.before[a, s])))
    return largest


@inner(**INLINE)
def _move_fields(part, fields):
    """Take only a part of the step of the fields."""
    for a in range(len(fields.order)):
        for s in range(LANES):
            fields.field[a, s] = fields.before[a, s] + part * (fields.field[a, s] - fields.before[a, s])


@njit(**SPREAD)
def _newton_step(law, modes, memory):
    """Fields, bodies and modes after a step from the loads there are; d, t and the stiffnesses k00, k01, k11."""
    k, h = modes.stiffness, modes.force
    k[:], h[:] = 0.0, 0.0
    for block in range(len(law.block)):
        rows, fields = block_rows(memory, block), field_rows(memory, block)
        sums = linearise(law.slope, rows, fields)
        h[0], h[1] = h[0] + sums[0], h[1] + sums[1]
        k[0, 0], k[0, 1], k[1, 1] = k[0, 0] + sums[2], k[0, 1] + sums[3], k[1, 1] + sums[4]
        _linearise_modes(block, rows, fields, modes)
    if law.spread_length > 0.0:
        sums = eliminate(int(law.slices), memory)
        h[0], h[1] = h[0] - sums[0], h[1] - sums[1]
        k[0, 0], k[0, 1], k[1, 1] = k[0, 0] - sums[2], k[0, 1] - sums[3], k[1, 1] - sums[4]
        _eliminate_modes(int(law.slices), modes, memory)
    d, t, stiffness = _in_series(law, modes)
    if law.spread_length > 0.0:
        for mode in range(len(modes.share)):
            for block in range(len(law.block)):
                fields = field_rows(memory, block)
                for a in range(len(fields.order)):
                    for s in range(LANES):
                        fields.from_load[a, s] -= modes.share[mode] * modes.answer[mode, block, a, s]
        substitute(int(law.slices), d, t, memory)
    return d, t, stiffness


@inner(**INLINE)
def _linearise_modes(block, rows, fields, modes):
    """The block's part of k and h of the modes, and b_k."""
    n, k, h = len(rows.order), modes.stiffness, modes.force
    for mode in range(len(modes.share)):
        value, i = modes.value[mode, block], 2 + mode
        for a in range(n):
            for s in range(LANES):
                total = 0.0
                for b in range(n):
                    total += fields.stiffness[a, b, s] * value[b, s]
                modes.right[mode, block, a, s] = rows.width[s] * fields.gain[a, s] * total
                total *= rows.width[s]
                k[0, i] += total
                k[1, i] += total * rows.y[s]
                h[i] += rows.width[s] * value[a, s] * fields.target[a, s]
                for other in range(mode + 1):
                    k[2 + other, i] += modes.value[other, block, a, s] * total


@njit(**SPREAD)
def _eliminate_modes(count, modes, memory):
    """A^-1 b_k while the slices nearer the middle are held, and its products with all b; after `eliminate`."""
    middle = count // 2
    for i in range(middle + 1):
        for s, inner_s in ((i, i + 1), (count - 1 - i, count - 2 - i)):
            if s != middle and i < middle:
                _pivot_modes(s, modes, field_rows(memory, s // LANES))
                link = field_rows(memory, s // LANES).link
                for mode in range(len(modes.share)):
                    for a in range(len(memory[2])):
                        passed = link[a, s % LANES] * modes.answer[mode, s // LANES, a, s % LANES]
                        modes.right[mode, inner_s // LANES, a, inner_s % LANES] += passed
    _pivot_modes(middle, modes, field_rows(memory, middle // LANES))


@inner(**INLINE)
def _pivot_modes(s, modes, f):
    """Solve the pivot of slice s for the modes."""
    block, lane, n, k, h = s // LANES, s % LANES, len(f.order), modes.stiffness, modes.force
    for mode in range(len(modes.share)):
        i = 2 + mode
        for a in range(n):
            x = 0.0
            for b in range(n):
                x += f.inverse[a, b, lane] * modes.right[mode, block, b, lane]
            modes.answer[mode, block, a, lane] = x
            own = modes.right[mode, block, a, lane]
            h[i] -= own * f.from_load[a, lane]
            k[0, i] -= own * f.from_approach[a, lane]
            k[1, i] -= own * f.from_tilt[a, lane]
            for other in range(mode + 1):
                k[2 + other, i] -= modes.right[other, block, a, lane] * x


@inner()
def _in_series(law, modes):
    """d, t and the stiffnesses with bodies and modes in series; the shares q of the modes into `modes`."""
    k, h, system = modes.stiffness, modes.force, modes.system
    n = len(h)
    for i in range(n):
        for j in range(i):
            k[i, j] = k[j, i]
    for j in range(n + 3):
        for i in range(n):
            system[i, j] = k[i, j] if j < n else (h[i] if j == n else k[i, j - n - 1])
        first, second = system[0, j], system[1, j]
        system[0, j], system[1, j] = law.body * first + law.skew * second, law.skew * first + law.tilt * second
    for i in range(n):
        system[i, i] += 1.0
    for i in range(n):
        largest = i
        for row in range(i + 1, n):
            largest = row if abs(system[row, i]) > abs(system[largest, i]) else largest
        for j in range(i, n + 3):
            system[i, j], system[largest, j] = system[largest, j], system[i, j]
        for row in range(n):
            if row != i:
                factor = system[row, i] / system[i, i]
                for j in range(i, n + 3):
                    system[row, j] -= factor * system[i, j]
    for i in range(n):
        for j in range(n, n + 3):
            system[i, j] /= system[i, i]
    for mode in range(n - 2):
        modes.share[mode] = system[2 + mode, n]
    k00, k01, k11 = k[0, 0], k[0, 1], k[1, 1]
    for j in range(n):
        k00 -= k[0, j] * system[j, n + 1]
        k01 -= k[0, j] * system[j, n + 2]
        k11 -= k[1, j] * system[j, n + 2]
    return system[0, n], system[1, n], (k00, k01, k11)


@inner(**INLINE)
def _shift(sign, modes, block, fields):
    """Take the displacement of the modes from the free approaches and the loads they lead to; sign -1: give back."""
    n = len(fields.order)
    for mode in range(len(modes.share)):
        value, q = modes.value[mode, block], sign * modes.share[mode]
        for a in range(n):
            for s in range(LANES):
                fields.free[a, s] -= q * value[a, s]
                for b in range(n):
                    fields.target[a, s] -= q * fields.stiffness[a, b, s] * value[b, s]


@inner(**INLINE)
def _add_modes(modes, memory, answer):
    """What the modes add to the energy and its slope along the cycle."""
    for mode in range(len(modes.share)):
        q = modes.share[mode]
        answer[2] += 0.5 * q * q
        for block in range(modes.value.shape[1]):
            rows = block_rows(memory, block)
            for a in range(len(rows.order)):
                for s in range(LANES):
                    load = rows.width[s] * rows.fraction[a, s] * rows.load[a, s]
                    answer[6] -= q * load * modes.slope[mode, block, a, s]


@inner()
def _least_move(law, own_cycle, d, t, modes):
    """The least displacement (m) by which bodies and modes relieve any pair that may touch."""
    least = math.inf
    for number in range(int(law.slices)):
        slices, s = slices_of(law, number // LANES), number % LANES
        move = d + t * slices.y[s]
        here = own_cycle + slices.shift[s]
        least = min(least, move)
        for p in range(math.ceil(here - law.start - law.cells / law.per_step), math.floor(here - law.start) + 1):
            cell, u = cell_of(law, max((here - p - law.start) * law.per_step, 0.0))
            taken, at = move, 0
            for i in range(len(modes.teeth)):
                table = law.pinion_mode if modes.teeth[i, 1] == 0.0 else law.wheel_mode
                side = p - int(modes.teeth[i, 0]) + 1
                for k in range(table.shape[4]):
                    if 0 <= side <= 2:
                        row = table[int(modes.teeth[i, 2]) - 1, side, number]
                        taken += modes.share[at + k] * (row[cell, k] + u * (row[cell + 1, k] - row[cell, k]))
                at += table.shape[4]
            least = min(least, taken)
    return least
