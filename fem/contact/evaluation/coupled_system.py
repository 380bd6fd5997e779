"""The linear problem of one Newton step of a coupled face, compiled: slices, then fields and bodies.

Let l = f + J^-1 r be the loads after a Newton step of every slice by itself at the free approach (no field, no body
displacement). With fields and bodies they are f = l - J^-1 (g v + d + t y), and with K = phi J^-1 the step reads

    (T + w g K g) v = w g phi l - w g K 1 (d + t y),    (d, t) = E (F, M).

All public functions take the law and `memory`, as for `fields.block_rows`.
"""

from __future__ import annotations

from numba import njit

from fem.contact.evaluation.fields import block_rows, eliminate, field_rows, in_series, substitute
from fem.contact.evaluation.hertz import compliance_of, hertz_depth
from fem.contact.evaluation.law_tables import LANES
from fem.contact.evaluation.slice_loads import couple
from fem.contact.evaluation.slice_rows import invert, largest_approach, state_of
from fem.contact.evaluation.slice_sums import block_sums
from fem.contact.part_contact import part_of, spared, spared_compliance
from fem.numerics.compiled import INLINE, SPREAD, SUMS, inner


@inner(**INLINE)
def take_state(law, states, which, memory):
    """Free approaches of a state, and idle loads of 1 where no pair carries.

    Parameters
    ----------
    law, memory : `LawTables`; as for `block_rows`, filled by `gather_face`
    states, which : `States` the face was gathered for; 0 or 1, the one to take
    """
    delta, psi = state_of(states, which)
    for block in range(len(law.block)):
        rows, fields = block_rows(memory, block), field_rows(memory, block)
        for a in range(len(rows.order)):
            for s in range(LANES):
                back = largest_approach(states, rows.y[s]) - (delta + psi * rows.y[s])
                fields.free[a, s] = fields.widest[a, s] - back
                rows.load[a, s] = rows.load[a, s] if rows.on[a, s] > 0.0 else 1.0
                rows.log[a, s] = rows.log[a, s] if rows.on[a, s] > 0.0 else 0.0
                rows.beyond[a, s] = 1.0


@njit(**SPREAD)
def newton_step(law, memory):
    """Fields and body displacements after a step from the loads there are: d, t and the stiffnesses k00, k01, k11."""
    force = moment = k = mixed = tilt = 0.0
    for block in range(len(law.block)):
        sums = linearise(law.slope, block_rows(memory, block), field_rows(memory, block))
        force, moment, k, mixed, tilt = force + sums[0], moment + sums[1], k + sums[2], mixed + sums[3], tilt + sums[4]
    if law.spread_length > 0.0:
        sums = eliminate(int(law.slices), memory)
        force, moment, k, mixed, tilt = force - sums[0], moment - sums[1], k - sums[2], mixed - sums[3], tilt - sums[4]
    d, t, stiffness = in_series(law, (k, mixed, tilt), force, moment)
    if law.spread_length > 0.0:
        substitute(int(law.slices), d, t, memory)
    return d, t, stiffness


@inner(**SUMS)
def linearise(slope, rows, fields):
    """phi l, K and the block's part of the field equations; returns the sums F, M, k, k y, k y^2 without fields."""
    n = len(rows.order)
    force = moment = k = mixed = tilt = 0.0
    for s in range(LANES):
        y, w = rows.y[s], rows.width[s]
        couple(rows, s)
        for a in range(n):
            f, depth, c = rows.load[a, s], rows.offset[a, s] - rows.log[a, s], rows.compliance[a, s]
            rise, per_whole = rows.rise[a, s], rows.per_whole[a, s]
            even = rows.even[a, s]
            part = part_of(f, per_whole, even)
            rest = fields.free[a, s] - f * (c + slope * hertz_depth(depth, rows.beyond[a, s]))
            rest += rise * spared(even, part)
            for b in range(n):
                if b != a:
                    rows.system[a, b, s] = rows.pull[a, b, s]
                    rest -= rows.pull[a, b, s] * rows.load[b, s]
            rows.system[a, a, s] = compliance_of(c, slope, depth) + rise * per_whole * spared_compliance(even, part)
            rows.rest[a, s] = rows.on[a, s] * rest
        invert(rows.order, rows.system, s)
        for a in range(n):
            on, phi, g = rows.on[a, s], rows.fraction[a, s], fields.gain[a, s]
            target, total = on * rows.load[a, s], 0.0
            for b in range(n):
                target += rows.system[a, b, s] * rows.rest[b, s]
                stiffness = on * phi * rows.system[a, b, s]
                total += stiffness
                fields.stiffness[a, b, s] = stiffness
                fields.inverse[a, b, s] = w * g * fields.gain[b, s] * stiffness
            fields.inverse[a, a, s] += fields.stay[a, s]
            target *= phi
            fields.target[a, s] = target
            fields.by_load[a, s], fields.by_approach[a, s] = w * g * target, w * g * total
            fields.by_tilt[a, s] = w * g * total * y
            stiff, load = w * total, w * target
            force += load
            moment += load * y
            k += stiff
            mixed += stiff * y
            tilt += stiff * y * y
    return force, moment, k, mixed, tilt


@njit(**SPREAD)
def face_sums(law, d, t, stiffness, memory, answer):
    """F, M, U, the three stiffnesses and dU/dc' of solved slices, fields and bodies.

    Parameters
    ----------
    law, memory : `LawTables`; as for `block_rows`, solved
    d, t : body displacements, m and rad
    stiffness : (3,) tuple as from `newton_step`, N/m, N, N m
    answer : (7,) out: N, N m, J, N/m, N, N m, J
    """
    force = moment = energy = rate = 0.0
    for block in range(len(law.block)):
        rows = block_rows(memory, block)
        sums, (held, along) = block_sums(law.slope, rows), held_by_fields(rows, field_rows(memory, block))
        force, moment = force + sums[0], moment + sums[1]
        energy, rate = energy + sums[2] + 0.5 * held, rate + sums[6] - along
    answer[0], answer[1], answer[2] = force, moment, energy + 0.5 * (d * force + t * moment)
    answer[3], answer[4], answer[5] = stiffness
    answer[6] = rate


@inner(**SUMS)
def held_by_fields(rows, fields):
    """Sums of w g phi f v and of w g' phi f v."""
    held = along = 0.0
    for a in range(len(rows.order)):
        for s in range(LANES):
            h = rows.width[s] * rows.fraction[a, s] * rows.load[a, s] * fields.field[a, s]
            held += fields.gain[a, s] * h
            along += fields.gain_slope[a, s] * h
    return held, along
