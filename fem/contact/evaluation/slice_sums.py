"""What solved slices answer, compiled: force, moment, energy, stiffness and the change of energy along the mesh cycle.

The mathematics stands in `fem.contact.evaluation.evaluator`.
"""

from __future__ import annotations

from numba import types

from fem.contact.evaluation.hertz import compliance_of
from fem.contact.evaluation.law_tables import LANES
from fem.contact.evaluation.slice_rows import invert
from fem.contact.part_contact import part_of, spared, spared_compliance, spared_work, spared_work_slope
from fem.numerics.compiled import FLOAT, INLINE, SUMS, inner

ANSWER = types.UniTuple(FLOAT, 14)  # of two states: F, M, U, dF/d delta, dF/d psi, dM/d psi, dU/dc
ANSWER_ROOM = 16  # numbers of memory


@inner(**SUMS)
def block_sums(slope, rows):
    """F, M, U, k, k y, k y^2 and dU/dc' of the slices of a block (slope: A)."""
    n = len(rows.order)
    force = moment = energy = k = mixed = tilt = rate = 0.0
    for s in range(LANES):
        load = stiff = stored = along = 0.0
        for a in range(n):
            for b in range(n):
                rows.system[a, b, s] = rows.pull[a, b, s]
            depth = rows.offset[a, s] - rows.log[a, s]
            own, per_whole = compliance_of(rows.compliance[a, s], slope, depth), rows.per_whole[a, s]
            even = rows.even[a, s]
            part = part_of(rows.load[a, s], per_whole, even)
            rows.system[a, a, s] = own + rows.rise[a, s] * per_whole * spared_compliance(even, part)
        invert(rows.order, rows.system, s)
        for a in range(n):
            f, phi, steep = rows.load[a, s], rows.fraction[a, s], rows.fraction_slope[a, s]
            depth, t = rows.offset[a, s] - rows.log[a, s], rows.beyond[a, s]
            half = 0.5 * f * f
            load += phi * f
            for b in range(n):
                stiff += rows.on[a, s] * phi * rows.system[a, b, s] * rows.on[b, s]
            bent = slope * (max(depth, 1.0) + 0.5 + 2.0 * (t - 0.25 * t * t - 0.75))
            own = rows.approach[a, s] * f - half * (rows.compliance[a, s] + bent)
            spread = slope * (1.0 + 2.0 * (t - 0.5 * t * t - 0.5)) * rows.offset_slope[a, s]
            rise, even, per_whole = rows.rise[a, s], rows.even[a, s], rows.per_whole[a, s]
            whole, part = 1.0 / per_whole, part_of(f, per_whole, even)
            work = spared_work(even, part)
            own += rise * whole * work
            eased = whole * (
                work * rows.rise_slope[a, s] + rise * spared_work_slope(even, part, work) * rows.even_slope[a, s]
            )
            eased += rise * (work - min(f * per_whole, 1.0) * spared(even, part)) * rows.whole_slope[a, s]
            stored += phi * own
            along += steep * own
            along -= phi * (f * rows.gap_slope[a, s] + half * (rows.compliance_slope[a, s] + spread))
            along += phi * eased
            for b in range(a + 1, n):
                both, other = f * rows.load[b, s], rows.fraction[b, s]
                value = rows.neighbour[a, b, s]
                stored -= value * phi * other * both
                along -= value * (steep * other + phi * rows.fraction_slope[b, s]) * both
                along -= rows.neighbour_slope[a, b, s] * phi * other * both
        y, w = rows.y[s], rows.width[s]
        force += w * load
        moment += w * load * y
        energy += w * stored
        k += w * stiff
        mixed += w * stiff * y
        tilt += w * stiff * y * y
        rate += w * along
    return force, moment, energy, k, mixed, tilt, rate


@inner(**INLINE)
def add_to(answer, first, sums):
    """Add sums to the answer (14,) from `first` on."""
    for i in range(len(sums)):
        answer[first + i] += sums[i]


@inner()
def keep_loads(rows, block, anchor, loads):
    """Line loads phi f of a block; pairs beyond the places are left out.

    Parameters
    ----------
    rows, block : solved `Rows` of a block of slices, and its number
    anchor : number of the pair at place places // 2
    loads : (place, slice) out: N/m where a pair carries, else as it was; pair p at place p - anchor + places // 2
    """
    places, slices = loads.shape
    for a in range(len(rows.order)):
        for s in range(LANES):
            place, number = int(rows.pair[a, s]) - anchor + places // 2, block * LANES + s
            if rows.load[a, s] > 0.0 and number < slices and 0 <= place < places:
                loads[place, number] = rows.fraction[a, s] * rows.load[a, s]


@inner(**INLINE)
def totals(answer, sign):
    """The answer (14,) as a tuple, with dU/dc for dU/dc'."""
    a = answer
    first = a[0], a[1], a[2], a[3], a[4], a[5], sign * a[6]
    return first + (a[7], a[8], a[9], a[10], a[11], a[12], sign * a[13])
