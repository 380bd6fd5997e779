"""Line loads, fields and body displacements of a coupled face in one Newton iteration, compiled.

The equations stand in `fem.contact.evaluation.coupled_face`, the linear problem of a step in `coupled_system`. Loads,
fields and bodies move at once: the slices need not be solved before the fields move. A pair leaves a slice when its
load falls below zero and returns where its approach is positive.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fem.contact.evaluation.coupled_system import face_sums, newton_step, take_state
from fem.contact.evaluation.fields import block_rows, field_rows
from fem.contact.evaluation.law_tables import LANES, slices_of
from fem.contact.evaluation.logarithm import SERIES, log_of_growth, logarithm, rough_log
from fem.contact.evaluation.slice_loads import couple
from fem.contact.evaluation.slice_rows import largest_approach, state_of
from fem.contact.part_contact import part_of, touch
from fem.numerics.compiled import INLINE, SPREAD, SUMS, inner

STEPS = 14
CLOSE = 1e-12  # of F: error at which the iteration ends


@njit(**SPREAD)
def solve_face(law, states, which, cold, memory, answer):
    """Loads of a gathered face at a state.

    Returns True if the iteration has settled within the range of the Hertz term, and d (m), t (rad).

    Parameters
    ----------
    law, memory : `LawTables`; as for `block_rows`, filled by `gather_face`
    states, which : `States` the face was gathered for; 0 or 1, the one to solve
    cold : True to start from scratch, False from the loads there are
    answer : (7,) out: as in `face_sums`
    """
    d = t = 0.0
    settled, stiffness = False, (0.0, 0.0, 0.0)
    take_state(law, states, which, memory)
    for block in range(len(law.block) if cold else 0):
        guess(law.slope, block_rows(memory, block), field_rows(memory, block))
    for _ in range(STEPS):
        d, t, stiffness = newton_step(law, memory)
        load = error = square = 0.0
        for block in range(len(law.block)):
            sums = advance(law.slope, d, t, block_rows(memory, block), field_rows(memory, block))
            load, error, square = load + sums[0], error + sums[1], square + sums[2]
        settled = square < 1.0 and error <= CLOSE * load
        if settled:
            break
    beyond = 0.0
    for block in range(len(law.block)):
        beyond += finish(law.slope, block_rows(memory, block))
    face_sums(law, d, t, stiffness, memory, answer)
    return settled and beyond == 0.0, d, t


@inner(**INLINE)
def guess(slope, rows, fields):
    """First line loads of a block, from secant compliances without body displacements."""
    bits = rows.load.view(np.int64)
    for s in range(LANES):
        for a in range(len(rows.order)):
            c, bent = rows.compliance[a, s], fields.gain[a, s] * fields.gain[a, s]
            left = (c + 5.0 * slope) / (c + 5.0 * slope + bent)
            x = touch(left * fields.free[a, s], rows.rise[a, s], rows.even[a, s]) / left
            rows.load[a, s] = x / (c + bent + 5.0 * slope)
            f = x / (c + bent + slope * max(1.0, rows.offset[a, s] - rough_log(bits[a, s])))
            rows.on[a, s], rows.load[a, s] = 1.0 if x > 0.0 else 0.0, f if x > 0.0 else 1.0
    logarithm(rows.load, rows.log, rows.rest)


@inner(**SUMS)
def advance(slope, d, t, rows, fields):
    """Loads at the fields and body displacements; `approach` takes what is left to the slice.

    Returns F, the bound sum w K A f step^2 / 2 of its error, from x'' = -A / f, with the relative steps of the loads,
    and the sum of step^2, 1 for a pair that switches.

    Parameters
    ----------
    slope : A of the law, m2/N
    d, t : body displacements, m and rad
    rows, fields : `Rows` and `FieldRows` of the block
    """
    n = len(rows.order)
    force = bend = total = 0.0
    for s in range(LANES):
        w, move = rows.width[s], d + t * rows.y[s]
        for a in range(n):
            rows.approach[a, s] = fields.free[a, s] - (move + fields.gain[a, s] * fields.field[a, s])
        for a in range(n):
            new = fields.target[a, s]
            for b in range(n):
                new -= fields.stiffness[a, b, s] * (move + fields.gain[b, s] * fields.field[b, s])
            on = rows.on[a, s] > 0.0
            new = new / (rows.fraction[a, s] if on else 1.0)
            rows.rest[a, s] = new if on and new > 0.0 else 0.0
        for a in range(n):
            left = rows.approach[a, s]
            for b in range(n):
                if b != a:
                    left -= rows.neighbour[a, b, s] * rows.fraction[b, s] * rows.rest[b, s]
            f, new, on, phi = rows.load[a, s], rows.rest[a, s], rows.on[a, s] > 0.0, rows.fraction[a, s]
            stays = new > 0.0
            rise = rows.rise[a, s]
            back = not stays and left + rise > 1e-15 * (abs(fields.free[a, s]) + rise) and left + rise > 1e-18
            fresh = touch(left, rise, rows.even[a, s]) / (rows.compliance[a, s] + 0.8 * slope * rows.offset[a, s])
            new = new if stays else (fresh if back else 1.0)
            step = (new - f) / f if stays else (1.0 if on or back else 0.0)
            rows.load[a, s], rows.on[a, s] = new, 1.0 if stays or back else 0.0
            rows.log[a, s] += log_of_growth(step)
            force += w * phi * new if stays else 0.0
            even, u = rows.even[a, s], min(new * rows.per_whole[a, s], 1.0)
            part = part_of(new, rows.per_whole[a, s], even)
            bent = slope * new + 0.5 * rise * (1.0 + even) ** 2 * u * u / (part * part * part)
            bend += w * fields.stiffness[a, a, s] * step * step * bent
            total += step * step
    if total > SERIES * SERIES:
        logarithm(rows.load, rows.log, rows.rest)
    return force, 0.5 * bend, total


@inner(**SUMS)
def finish(slope, rows):
    """f = 0 where a pair does not carry; returns the number of loads beyond the range of the Hertz term."""
    beyond = 0.0
    for s in range(LANES):
        couple(rows, s)
        for a in range(len(rows.order)):
            depth = rows.offset[a, s] - rows.log[a, s]
            beyond += rows.on[a, s] if slope > 0.0 and depth < 1.0 else 0.0
            rows.load[a, s] *= rows.on[a, s]
    return beyond


@inner(**INLINE)
def covered(law, states, which, d, t):
    """True if no slice approaches further than the states for which the pairs were collected.

    Parameters
    ----------
    law : `LawTables`
    states, which : `States` the pairs were collected for; 0 or 1, the one that is solved
    d, t : body displacements in that state, m and rad
    """
    delta, psi = state_of(states, which)
    for block in range(len(law.block)):
        y = slices_of(law, block).y
        for s in range(LANES):
            own = delta + psi * y[s]
            room = largest_approach(states, y[s]) - own + 1e-14 * abs(own)  # of rounding, where nothing moves
            if -(d + t * y[s]) > room:
                return False
    return True
