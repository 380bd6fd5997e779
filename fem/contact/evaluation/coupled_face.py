"""Mesh laws whose slices are coupled along the face, compiled: tooth bending that spreads, wind-up and tilt of bodies.

With the slice potentials U_s, convex in the approach of each pair, the law of `fem.contact.law` is the minimum of

    sum_s w_s U_s(x_s - g v_s - d - t y_s) + v' T v / 2 + (d, t) E^-1 (d, t)' / 2,   g = sqrt(D)

over the fields v_p (one per pair) and the body displacements d, t; E = [E_0 E_01; E_01 E_1], and T stands for
1 - a^2 d^2/dy^2 between the slices (diagonal w_s, springs a^2 / distance between neighbours, nothing beyond the ends).
All parts are convex, so the minimum is unique and U stays convex in (delta, psi). Newton's method
(`fem.contact.evaluation.coupled_newton`): the stiffnesses K_s = phi J^-1 of the slices enter

    (T + w g K g) dv = w g phi f - T v - w g K 1 (dd + dt y)

which is tridiagonal in blocks of the pairs; d and t are coupled with everything. F, M, U and all derivatives are those
of the minimum (envelope theorem); the total stiffness is the slices' with fields and bodies in series.

A slice loads few pairs, so lines that never meet in one slice share a row: two or three rows of fields are enough for
slices of at most two or three pairs, however many the face holds. Hertz contacts bend little, so three or four steps
reach round-off. Bodies that tilt can bring pairs into contact that the free approach leaves open; the candidates are
then collected anew for an approach wide enough, and the answer is checked against it. What does not settle so, slices
of more pairs and neighbours that pull are solved by `fem.contact.evaluation.damaged_face.settle_exactly`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fem.contact.evaluation.coupled_newton import covered, solve_face
from fem.contact.evaluation.damaged_face import keep_all_loads, settle_exactly
from fem.contact.evaluation.fields import face_room, gather_face
from fem.contact.evaluation.law_tables import unpacked
from fem.contact.evaluation.near_pairs import NEAR_ROOM, near_pairs
from fem.contact.evaluation.slice_rows import STATES, States, state_alone, state_of
from fem.contact.evaluation.slice_sums import ANSWER, ANSWER_ROOM, totals
from fem.numerics.compiled import MATRIX, SPREAD, VECTOR, apart, stored

ROOM = ANSWER_ROOM + NEAR_ROOM


@apart(ANSWER, VECTOR, STATES, MATRIX, MATRIX, MATRIX)
@stored(__file__, entry=False)
def evaluate_coupled(packed, states, pinion, wheel, loads):
    """Answer (14,) at one or two states, in the order of `slice_sums.ANSWER`.

    Parameters
    ----------
    packed : (n,) from `law_tables.pack`
    states : `States`
    pinion, wheel : (z1, 6) and (z2, 6) tooth terms, see `fem.contact.teeth`
    loads : (place, slice) out: line loads of the last state as in `keep_loads`; (0, 0) if they are not asked for
    """
    law = unpacked(packed)
    memory = np.empty(ROOM + face_room(len(law.block), 2))
    answer = memory[:14]  # holds the memory as long as it is used; all other views are lent
    if _evaluate(packed, states, pinion, wheel, loads, (memory, ROOM, (0, 1))) > 2:
        return _evaluate_three(packed, states, pinion, wheel, loads)
    return totals(answer, law.sign)


@apart(ANSWER, VECTOR, STATES, MATRIX, MATRIX, MATRIX)
@stored(__file__, entry=False)
def _evaluate_three(packed, states, pinion, wheel, loads):
    """`evaluate_coupled` with three rows of fields: where more than two pairs approach in a slice."""
    law = unpacked(packed)
    memory = np.empty(ROOM + face_room(len(law.block), 3))
    answer = memory[:14]
    _evaluate(packed, states, pinion, wheel, loads, (memory, ROOM, (0, 1, 2)))
    return totals(answer, law.sign)


@njit(**SPREAD)
def _evaluate(packed, states, pinion, wheel, loads, memory):
    """The answer (14,) at the start of memory, as for `fields.block_rows`; returns the rows that are needed.

    Two rows give up where they are too few; three leave the rest to exact slices.
    """
    law, answer, near_room = unpacked(packed), memory[0][:14], memory[0][ANSWER_ROOM:]
    own_cycle, most = law.sign * states.cycle + law.offset, len(memory[2])
    near = near_pairs(law, own_cycle, pinion, wheel, near_room)
    answer[:] = 0.0
    fresh, cold, found = True, True, 0
    for which in range(states.asked):
        asked, of, good, wider = states, which, False, False
        for _ in range(2):
            if fresh:
                found, fresh = gather_face(law, near, own_cycle, asked, 0.0, memory), False
            if found != most or law.pulls > 0.0:
                break
            settled, d, t = solve_face(law, asked, of, cold, memory, answer[7 * which : 7 * which + 7])
            good = settled and covered(law, asked, of, d, t)
            if good or wider or not settled:
                break
            delta, psi = state_of(states, which)
            asked, of, wider = States(states.cycle, delta, psi, delta - 2.0 * d, psi - 2.0 * t, 1), 0, True
            fresh, cold = True, True
        if found > most and most == 2:
            return found
        if good and loads.size > 0:
            keep_all_loads(law, own_cycle, memory, loads)
        if not good and (found > 0 or law.pulls > 0.0):
            settle_exactly(packed, state_alone(states, which), pinion, wheel, loads, answer[7 * which : 7 * which + 7])
        fresh, cold = wider, wider or not good
    return most
