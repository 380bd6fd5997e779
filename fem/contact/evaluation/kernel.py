"""Compiled entry to the mesh law: one or two states in, forces, energy and their derivatives out.

`packed` is the vector of `fem.contact.evaluation.law_tables.pack` (`LawEvaluator.packed`), `pinion` and `wheel` are the
tooth terms of `fem.contact.teeth`. The mathematics stands in `fem.contact.evaluation.evaluator`; the line loads of a
slice are solved in `fem.contact.evaluation.slice_loads`, those of a coupled face in
`fem.contact.evaluation.coupled_newton`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from fem.contact.evaluation.coupled_face import evaluate_coupled
from fem.contact.evaluation.damaged_face import evaluate_damaged, settle_exactly
from fem.contact.evaluation.law_tables import unpacked
from fem.contact.evaluation.near_pairs import NEAR_ROOM, damaged_teeth, near_pairs
from fem.contact.evaluation.slice_loads import move_approach, solve_slices
from fem.contact.evaluation.slice_rows import (
    NEVER,
    STATES,
    States,
    gather,
    nearest_approach,
    rows_in,
    rows_room,
    state_alone,
)
from fem.contact.evaluation.slice_sums import ANSWER, ANSWER_ROOM, add_to, block_sums, keep_loads, totals
from fem.numerics.compiled import INLINE, MATRIX, SPREAD, VECTOR, apart, inner, stored

ROOM = ANSWER_ROOM + NEAR_ROOM


@apart(ANSWER, VECTOR, STATES, MATRIX, MATRIX, MATRIX)
@stored(__file__, entry=False)
def _evaluate_independent(packed, states, pinion, wheel, loads):
    """Answer of a law whose slices are independent of one another, and the line loads of the last state."""
    law = unpacked(packed)
    memory = np.empty(ROOM + rows_room(2))
    answer = memory[:14]  # holds the memory as long as it is used; all other views are lent
    if _solve_blocks(law, states, pinion, wheel, loads, (memory, ROOM, (0, 1))) > 2:
        return _evaluate_three(packed, states, pinion, wheel, loads)
    return totals(answer, law.sign)


@apart(ANSWER, VECTOR, STATES, MATRIX, MATRIX, MATRIX)
@stored(__file__, entry=False)
def _evaluate_three(packed, states, pinion, wheel, loads):
    """`_evaluate_independent` where more than two pairs approach in a slice; more than three are solved exactly."""
    law = unpacked(packed)
    memory = np.empty(ROOM + rows_room(3))
    answer = memory[:14]
    if _solve_blocks(law, states, pinion, wheel, loads, (memory, ROOM, (0, 1, 2))) > 3:
        answer[:] = 0.0
        for which in range(states.asked):
            settle_exactly(packed, state_alone(states, which), pinion, wheel, loads, answer[7 * which : 7 * which + 7])
    return totals(answer, law.sign)


@njit(**SPREAD)
def _solve_blocks(law, states, pinion, wheel, loads, memory):
    """The answer (14,) at the start of memory, as for `fields.block_rows`; the rows that are needed, if they are more.

    All blocks take turns in the memory of the first.
    """
    answer, near_room, most = memory[0][:14], memory[0][ANSWER_ROOM:], len(memory[2])
    own_cycle, lowest = law.sign * states.cycle + law.offset, NEVER if law.pulls > 0.0 else 0.0
    answer[:] = 0.0
    near = near_pairs(law, own_cycle, pinion, wheel, near_room)
    rows = rows_in(memory[0], memory[1], memory[2])
    for block in range(len(law.block)):
        found = gather(law, near, block, own_cycle, states, lowest, rows)
        if found > most:
            return found
        if found > 0:
            _solve_block(law, block, states, rows, loads, answer)
    return most


@njit(**SPREAD)
def _solve_block(law, block, states, rows, loads, answer):
    """Add the sums of a gathered block to the answer (14,); the second state starts from the loads of the first."""
    for which in range(states.asked):
        move_approach(states, which, rows)
        solve_slices(law.slope, which == 0, rows)
        add_to(answer, 7 * which, block_sums(law.slope, rows))
    if loads.size > 0:
        keep_loads(rows, block, math.floor(law.sign * states.cycle + law.offset), loads)


@inner(**INLINE)
def _respond(packed, states, pinion, wheel, loads):
    """Answer at one or two states; the line loads of the last one into loads (place, slice), if that is not empty."""
    law = unpacked(packed)
    known, own_cycle = law.pinion_modes + law.wheel_modes > 0.0, law.sign * states.cycle + law.offset
    if known and damaged_teeth(law, own_cycle, pinion, wheel, np.empty((0, 0))) > 0:
        return evaluate_damaged(packed, states, pinion, wheel, loads)
    if law.coupled > 0.0:
        return evaluate_coupled(packed, states, pinion, wheel, loads)
    return _evaluate_independent(packed, states, pinion, wheel, loads)


@stored(__file__)
def evaluate(packed, cycle, delta, psi, pinion, wheel):
    """Response of one flank at one state.

    Parameters
    ----------
    packed : (n,), see `LawEvaluator.packed`
    cycle : mesh cycle c of the gears (1); the law turns it into its own c'
    delta, psi : approach along the transverse line of action (m) and tilt (rad)
    pinion, wheel : (z1, 6) and (z2, 6) tooth terms, see `fem.contact.teeth`

    Returns
    -------
    F (N), M (N m), U (J), dF/d delta (N/m), dF/d psi = dM/d delta (N), dM/d psi (N m), dU/dc (J)
    """
    return _respond(packed, States(cycle, delta, psi, delta, psi, 1), pinion, wheel, np.empty((0, 0)))[:7]


@stored(__file__)
def evaluate_two(packed, cycle, delta, psi, delta_0, psi_0, pinion, wheel):
    """Responses at (delta, psi) and at (delta_0, psi_0), both at the same cycle, without dU/dc; see `evaluate`.

    The tables are read once and the second Newton iteration starts from the line loads of the first.

    Parameters
    ----------
    packed, cycle, pinion, wheel : as in `evaluate`
    delta, psi, delta_0, psi_0 : m and rad of the first state, then of the second

    Returns
    -------
    F, M, U, dF/d delta, dF/d psi, dM/d psi of the first state, then the same of the second
    """
    found = _respond(packed, States(cycle, delta, psi, delta_0, psi_0, 2), pinion, wheel, np.empty((0, 0)))
    return found[:6] + found[7:13]


@stored(__file__)
def evaluate_many(packed, states, pinion, wheel, answer, loads):
    """`evaluate` for many states, with their line loads.

    Parameters
    ----------
    packed, pinion, wheel : as in `evaluate`
    states : (n, 3) cycle (1), delta (m) and psi (rad)
    answer : (n, 7) out: rows of `evaluate`
    loads : (n, place, slice) out: phi f, N/m, pair p at place p - floor(c') + places // 2 and left out beyond the
        places; (0, 0, 0) if they are not asked for
    """
    none = np.empty((0, 0))
    for i in range(len(states)):
        cycle, delta, psi = states[i, 0], states[i, 1], states[i, 2]
        kept = loads[i] if loads.size > 0 else none
        found = _respond(packed, States(cycle, delta, psi, delta, psi, 1), pinion, wheel, kept)
        for j in range(7):
            answer[i, j] = found[j]


@stored(__file__)
def first_touch(packed, cycles, psi, pinion, wheel, found):
    """delta_0, the approach at which the first pair touches.

    Parameters
    ----------
    packed, pinion, wheel : as in `evaluate`
    cycles, psi : (n,) mesh cycles c (1) and tilts (rad)
    found : (n,) out: delta_0 in m, inf where no pair can touch
    """
    law, room = unpacked(packed), np.empty(NEAR_ROOM)
    for i in range(len(cycles)):
        own_cycle = law.sign * cycles[i] + law.offset
        near = near_pairs(law, own_cycle, pinion, wheel, room)
        found[i] = -nearest_approach(law, near, own_cycle, psi[i])
    room[0] = 0.0  # `near` was lent from it
