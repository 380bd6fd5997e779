"""Compiled entry to the mesh law: a state in, forces, energy and their derivatives out.

`packed` is the vector of `fem.contact.evaluation.law_tables.pack` (`LawEvaluator.packed`), `pinion` and `wheel` are the
tooth terms of `fem.contact.teeth`. The mathematics is in `fem.contact.evaluation.solver`.
"""

from __future__ import annotations

import math

from fem.contact.evaluation.law_tables import unpacked
from fem.contact.evaluation.slice_contacts import near_pairs, nearest_approach
from fem.contact.evaluation.solver import respond
from fem.numerics.compiled import stored
from fem.numerics.inner_functions import UNCOUNTED

ROUNDS = 200
CLOSE = 1e-12  # of the force
STEP = 1e-6  # m, above the approach of first touch
LONGEST = 4.0  # times the approach
ROUNDED = 4e-16  # of the approach


@stored(__file__, **UNCOUNTED)
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
    F (N), M (N m), U (J), dF/d delta (N/m), dF/d psi = dM/d delta (N), dM/d psi (N m)
    """
    return respond(packed, cycle, delta, psi, pinion, wheel, pinion[:0])


@stored(__file__, **UNCOUNTED)
def evaluate_many(packed, states, pinion, wheel, answer, loads):
    """`evaluate` for many states, with their line loads.

    Parameters
    ----------
    packed, pinion, wheel : as in `evaluate`
    states : (n, 3) cycle (1), delta (m) and psi (rad)
    answer : (n, 6) out: rows of `evaluate`
    loads : (n, place, slice) out: phi f, N/m, pair p at place p - floor(c') + places // 2 and left out beyond the
        places; (1, 0, 0) if they are not needed
    """
    for i in range(len(states)):
        kept = loads[i % len(loads)]
        found = respond(packed, states[i, 0], states[i, 1], states[i, 2], pinion, wheel, kept)
        for j in range(6):
            answer[i, j] = found[j]


@stored(__file__, **UNCOUNTED)
def first_touch(packed, cycles, psi, pinion, wheel, memory, found):
    """delta_0, the approach at which the first pair touches.

    Parameters
    ----------
    packed, pinion, wheel : as in `evaluate`
    cycles, psi : (n,) mesh cycles c (1) and tilts (rad)
    memory : (NEAR_ROOM,) to work in
    found : (n,) out: delta_0 in m, inf where no pair can touch
    """
    law = unpacked(packed)
    for i in range(len(cycles)):
        own_cycle = law.sign * cycles[i] + law.offset
        near = near_pairs(law, own_cycle, pinion, wheel, memory)
        found[i] = -nearest_approach(law, near, own_cycle, psi[i])


@stored(__file__, **UNCOUNTED)
def approach_many(packed, forces, cycles, psi, pinion, wheel, touch, found):
    """delta at which the law carries forces: safeguarded Newton on the rising F(delta).

    It starts from the position before and the force before, whose solutions are near. A trial outside the bracket is
    replaced by its middle, or without an upper end by a step away from the lower one.

    Parameters
    ----------
    packed, pinion, wheel : as in `evaluate`
    forces : (m,) N, > 0, ascending
    cycles, psi : (n,) mesh cycles c (1) and tilts (rad)
    touch : (n,) delta_0, see `first_touch`
    found : (n, m) out: delta in m, nan where the force is not reached
    """
    for i in range(len(cycles)):
        for j in range(len(forces)):
            delta = found[i - 1, j] if i > 0 else touch[i]
            if j > 0:
                delta = found[i, j - 1] + (delta - found[i - 1, j - 1] if i > 0 else 0.0)
            delta, low, high = max(delta, touch[i] + STEP), touch[i], math.inf
            found[i, j] = math.nan
            for _ in range(ROUNDS):
                response = respond(packed, cycles[i], delta, psi[i], pinion, wheel, pinion[:0])
                rest = forces[j] - response[0]
                low, high = (delta, high) if rest > 0.0 else (low, delta)
                trial = delta + rest / response[3] if response[3] > 0.0 else math.inf
                most = high if high < math.inf else low + LONGEST * (abs(low) + STEP)
                if not low < trial < most:
                    trial = 0.5 * (low + most)
                if abs(rest) <= CLOSE * forces[j] or abs(trial - delta) <= ROUNDED * abs(delta):
                    found[i, j] = delta
                    break
                delta = trial
