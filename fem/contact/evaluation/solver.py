"""Mesh law, compiled: the line loads of all slices of a face, with everything that couples them, at one state.

With the slice potentials U_s, convex in the approach of each pair, the law of `fem.contact.law` is the minimum of

    sum_s w_s U_s(x_s - g v_s - d - t y_s - sum_k m_k q_k) + v' T v / 2 + (d, t) E^-1 (d, t)' / 2 + sum_k q_k^2 / 2

over the fields v_p of tooth bending along the face (one per pair, g = sqrt(D)), the displacements d, t of the bodies
and the shares q_k of the modes of damaged teeth. E = [E_0 E_01; E_01 E_1], and T stands for 1 - a^2 d^2/dy^2 between
the slices (diagonal w_s, springs a^2 / distance between neighbours, nothing beyond the ends). Independent slices are
the case without fields, bodies and modes. All parts are convex, so that the minimum is unique and U stays convex in
(delta, psi); F, M, U and all derivatives are those of the minimum (envelope theorem).

One Newton step moves loads, fields, bodies and modes at once (`newton_system`). A pair leaves a slice when its load
falls below zero and returns where its approach is positive. Hertz contacts bend little (x'' = -A / f), so that three to
five steps reach round-off. What does not settle so is solved by slices that are exact at held fields, bodies and modes,
coordinate by coordinate, which always converges for a convex function, and a Newton step of the rest, in turn.

Three compiled versions of the same code. `respond` has two rows of pairs and no modes, and gathers the pairs whose free
approach is positive. `respond_with_modes` (three rows, damaged teeth with modes, pairs that come near without touching)
takes over where a slice has more pairs, a tooth has modes, bodies tilt a pair into contact that has no free approach,
or nothing settles. `respond_exactly` has as many rows as it needs, gathers every pair within
reach, and is the one that always ends; neighbours that pull go there at once.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, types

from fem.contact.evaluation.law_tables import LANES, LARGEST_NEAR, SHIFT, WIDTH, Y, blocks_of, unpacked
from fem.contact.evaluation.line_contact import (
    SERIES,
    hertz_validity,
    log_of_growth,
    logarithm,
    rough_log,
    single_load,
)
from fem.contact.evaluation.newton_system import bodies_in_series, newton_step
from fem.contact.evaluation.slice_contacts import (
    BEND,
    BEYOND,
    BODIES,
    COUPLED,
    EVEN,
    FIELD,
    FIELD_BEFORE,
    FREE,
    GAIN,
    LOAD,
    LOG,
    MOVED,
    MOVED_BEFORE,
    NEAR_ROOM,
    NEVER,
    OFFSET,
    ON,
    PAIR,
    PAIR_FIELDS,
    PER_WHOLE,
    PHI,
    REST,
    RETURNED,
    RISE,
    SOFTNESS,
    STIFFNESS,
    SYSTEM,
    TARGET,
    cell_of,
    damaged_teeth,
    fields_of,
    gather,
    gather_modes,
    mode_at,
    near_pairs,
)
from fem.contact.part_contact import part_of, reduction_of_work, touch
from fem.numerics.compiled import FLOAT, MATRIX, SPREAD, SUMS, VECTOR, by_address, stored, views
from fem.numerics.inner_functions import INLINE, inner

STEPS = 14
ASIDE = 0.25  # of the approach: pairs this far apart are gathered, for modes that lift a tooth towards its mate
CLOSE = 1e-13  # of F: bound of the error at which the iteration ends
EXACT_STEPS = 40
EXACT_CLOSE = 1e-11  # step of the displacements, relative to the largest, at which the loads found before it are taken
ANSWER = types.UniTuple(FLOAT, 6)  # F, M, U, dF/d delta, dF/d psi, dM/d psi


@by_address(ANSWER, VECTOR, FLOAT, FLOAT, FLOAT, MATRIX, MATRIX, MATRIX)
@stored(__file__, entry=False)
def respond(packed, cycle, delta, psi, pinion, wheel, loads):
    """F (N), M (N m), U (J), dF/d delta (N/m), dF/d psi = dM/d delta (N) and dM/d psi (N m) at one state.

    Parameters
    ----------
    packed : (n,) from `law_tables.pack`
    cycle, delta, psi : mesh cycle c, approach (m) and tilt (rad)
    pinion, wheel : (z1, 6) and (z2, 6) tooth terms, see `fem.contact.teeth`
    loads : (place, slice) out: line loads phi f, N/m, pair p at place p - floor(c') + places // 2 and left out beyond
        the places; empty if they are not needed
    """
    memory = np.empty(NEAR_ROOM + BODIES * (BODIES + 2) + blocks_of(packed) * 2 * fields_of(2, 0) * LANES)
    found, answer = _by_two_rows(packed, cycle, delta, psi, pinion, wheel, loads, memory)
    return answer if found <= 2 else respond_with_modes(packed, cycle, delta, psi, pinion, wheel, loads)


@by_address(ANSWER, VECTOR, FLOAT, FLOAT, FLOAT, MATRIX, MATRIX, MATRIX)
@stored(__file__, entry=False)
def respond_with_modes(packed, cycle, delta, psi, pinion, wheel, loads):
    """`respond` with three rows of pairs and the modes of damaged teeth.

    Parameters
    ----------
    packed, cycle, delta, psi, pinion, wheel, loads : those of `respond`
    """
    teeth = np.empty((2 * LARGEST_NEAR, 3))
    count, modes = _modes_near(packed, cycle, pinion, wheel, teeth)
    small = (modes + BODIES) * (modes + BODIES + 2)
    memory = np.empty(NEAR_ROOM + small + blocks_of(packed) * 3 * fields_of(3, modes) * LANES)
    found, answer = _by_three_rows(packed, cycle, delta, psi, pinion, wheel, loads, teeth[:count], modes, memory)
    return answer if found <= 3 else respond_exactly(packed, cycle, delta, psi, pinion, wheel, loads)


@by_address(ANSWER, VECTOR, FLOAT, FLOAT, FLOAT, MATRIX, MATRIX, MATRIX)
@stored(__file__, entry=False)
def respond_exactly(packed, cycle, delta, psi, pinion, wheel, loads):
    """`respond` for any number of pairs in a slice, by an iteration that always ends.

    Parameters
    ----------
    packed, cycle, delta, psi, pinion, wheel, loads : those of `respond`
    """
    teeth, rows, found = np.empty((2 * LARGEST_NEAR, 3)), 1, 2
    count, modes = _modes_near(packed, cycle, pinion, wheel, teeth)
    small, shares = np.empty((modes + BODIES, modes + BODIES + 2)), np.empty(modes + BODIES)
    answer = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    while found > rows:
        rows += 1
        memory = np.empty(NEAR_ROOM + blocks_of(packed) * rows * fields_of(rows, modes) * LANES)
        found, answer = _by_any_rows(
            packed, cycle, delta, psi, pinion, wheel, loads, teeth[:count], modes, rows, small, shares, memory
        )
    return answer


@inner()
def _modes_near(packed, cycle, pinion, wheel, teeth):
    """Number of the damaged teeth near mesh, which are put into `teeth` as by `damaged_teeth`, and of their modes."""
    law, modes = unpacked(packed), 0
    count = damaged_teeth(law, law.sign * cycle + law.offset, pinion, wheel, teeth)
    for i in range(count):
        modes += int(law.pinion_modes if teeth[i, 1] == 0.0 else law.wheel_modes)
    return count, modes


@inner()
def _by_two_rows(packed, cycle, delta, psi, pinion, wheel, loads, memory):
    """`respond` with two rows of pairs and no modes: the rows that are needed, more than 2 if that fails; answer."""
    law, found = unpacked(packed), 3
    own_cycle, blocks, fields = law.sign * cycle + law.offset, len(law.block), fields_of(2, 0)
    near = near_pairs(law, own_cycle, pinion, wheel, memory)
    small = views(memory, NEAR_ROOM, 1, (BODIES, BODIES + 2))[0]
    r = views(memory, NEAR_ROOM + BODIES * (BODIES + 2), 1, (blocks, 2, fields, LANES))[0]
    if law.pulls == 0.0 and not (
        law.pinion_modes + law.wheel_modes > 0.0 and damaged_teeth(law, own_cycle, pinion, wheel, r[0, 0, :0]) > 0
    ):
        found = gather(law, near, own_cycle, delta, psi, 0.0, 2, r)
    answer = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if found == 2:
        settled, stiffness = _settle(law, 2, 0, r, small)
        if settled and _covered(law.block, delta, psi, small):
            answer = _sums(law, own_cycle, 2, 0, r, small, stiffness, loads)
        else:
            found = 3
    return found, answer


@inner()
def _by_three_rows(packed, cycle, delta, psi, pinion, wheel, loads, teeth, modes, memory):
    """`respond` with three rows and modes: the rows that are needed, more than 3 if that fails; answer."""
    law, found = unpacked(packed), 4
    own_cycle, blocks, fields = law.sign * cycle + law.offset, len(law.block), fields_of(3, modes)
    near = near_pairs(law, own_cycle, pinion, wheel, memory)
    small = views(memory, NEAR_ROOM, 1, (modes + BODIES, modes + BODIES + 2))[0]
    r = views(memory, NEAR_ROOM + (modes + BODIES) * (modes + BODIES + 2), 1, (blocks, 3, fields, LANES))[0]
    aside = ASIDE * (abs(delta) + abs(psi * law.block[0, 0, 0]))
    if law.pulls == 0.0:
        found = gather(law, near, own_cycle, delta, psi, -aside, 3, r)
    answer = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if found == 3:
        gather_modes(law, teeth, 3, r)
        settled, stiffness = _settle(law, 3, modes, r, small)
        if settled and _least_move(law, own_cycle, teeth, small) >= -aside:
            answer = _sums(law, own_cycle, 3, modes, r, small, stiffness, loads)
        else:
            found = 4
    return found, answer


@inner()
def _by_any_rows(packed, cycle, delta, psi, pinion, wheel, loads, teeth, modes, rows, small, shares, memory):
    """`respond` with all pairs within reach: the rows that are needed, more than there are if that fails; answer."""
    law = unpacked(packed)
    own_cycle = law.sign * cycle + law.offset
    near = near_pairs(law, own_cycle, pinion, wheel, memory)
    r = views(memory, NEAR_ROOM, 1, (len(law.block), rows, fields_of(rows, modes), LANES))[0]
    found = gather(law, near, own_cycle, delta, psi, NEVER, rows, r)
    answer = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if found == rows:
        gather_modes(law, teeth, rows, r)
        stiffness = _settle_in_turn(law, rows, modes, r, small, shares)
        answer = _sums(law, own_cycle, rows, modes, r, small, stiffness, loads)
    return found, answer


@njit(**SPREAD)
def _settle(law, rows, modes, r, small):
    """Loads of a gathered face from scratch; True if the iteration has settled, and the stiffnesses."""
    settled, stiffness = False, (0.0, 0.0, 0.0)
    bits = r.view(np.int64)
    _guess(law, rows, r, bits)
    for _ in range(STEPS):
        _, _, stiffness = newton_step(law, rows, modes, r, small)
        load = error = square = 0.0
        for block in range(r.shape[0]):
            sums = _advance(law.slope, law.block, block, rows, r, bits)
            load, error, square = load + sums[0], error + sums[1], square + sums[2]
        settled = square < 1.0 and error <= CLOSE * load
        if settled:
            break
    return settled, stiffness


@njit(**SPREAD)
def _guess(law, rows, r, bits):
    """First line loads from secant compliances, with bodies and with fields as under an even load."""
    force = moment = k = mixed = tilt = 0.0
    for block in range(r.shape[0]):
        sums = _secants(law.slope, law.block, block, rows, r)
        force, moment, k, mixed, tilt = force + sums[0], moment + sums[1], k + sums[2], mixed + sums[3], tilt + sums[4]
    d, t, _ = bodies_in_series(law.body, law.skew, law.tilt, force, moment, (k, mixed, tilt))
    for block in range(r.shape[0]):
        for s in range(LANES):
            for a in range(rows):
                secant, stiff = r[block, a, SOFTNESS, s] + 5.0 * law.slope, r[block, a, TARGET, s]
                left, x = secant * stiff, r[block, a, FREE, s] - d - t * law.block[block, Y, s]
                x = touch(left * x, r[block, a, RISE, s], r[block, a, EVEN, s]) / left
                r[block, a, LOAD, s], r[block, a, ON, s] = x * stiff, 1.0 if x > 0.0 else 0.0
                depth = max(1.0, r[block, a, OFFSET, s] - rough_log(bits[block, a, LOAD, s]))
                bent = r[block, a, GAIN, s] * r[block, a, GAIN, s]
                f = x / (r[block, a, SOFTNESS, s] + bent + law.slope * depth)
                r[block, a, LOAD, s] = f if x > 0.0 else 1.0
        for a in range(rows):
            logarithm(r[block, a], bits[block, a], LOAD, LOG, REST)


@inner(**SUMS)
def _secants(slope, face, block, rows, r):
    """Secant stiffness of every pair into TARGET; the sums of `newton_system._linearise` where it approaches freely."""
    force = moment = k = mixed = tilt = 0.0
    for s in range(LANES):
        y = face[block, Y, s]
        for a in range(rows):
            secant, bent = r[block, a, SOFTNESS, s] + 5.0 * slope, r[block, a, GAIN, s] * r[block, a, GAIN, s]
            stiff, free = 1.0 / (secant + bent), r[block, a, FREE, s]
            r[block, a, TARGET, s] = stiff
            stiff *= face[block, WIDTH, s] * r[block, a, PHI, s] * (1.0 if free > 0.0 else 0.0)
            load = stiff * max(free, 0.0)
            force += load
            moment += load * y
            k += stiff
            mixed += stiff * y
            tilt += stiff * y * y
    return force, moment, k, mixed, tilt


@inner(**SUMS)
def _advance(slope, face, block, rows, r, bits):
    """Loads of a block after a Newton step; a pair that does not carry gets f = 1.

    Returns F, a bound of its error and the sum of step^2 with the relative steps of the loads, 1 for a pair that
    switches. The bound is sum w K (A f + a/(2 (1 - p)^2)) step^2 / 2 from the second derivatives of x(f): -A / f, and
    at most that of the part of a slice in contact.
    """
    force = bend = total = deepest = returned = 0.0
    for s in range(LANES):
        for a in range(rows):
            moved, on = 0.0, r[block, a, ON, s]
            for b in range(rows):
                moved += r[block, a, SYSTEM + PAIR_FIELDS * b, s] * r[block, b, ON, s] * r[block, b, MOVED, s]
            r[block, a, REST, s] = on * max(r[block, a, TARGET, s] - moved, 0.0)
        for a in range(rows):  # numbers instead of branches, which would keep the loop from vectors
            free, rise = r[block, a, FREE, s], r[block, a, RISE, s]
            left = free + rise - r[block, a, MOVED, s]
            for b in range(rows):
                if b != a:
                    left -= r[block, a, COUPLED + PAIR_FIELDS * b, s] * r[block, b, PHI, s] * r[block, b, REST, s]
            f, new = r[block, a, LOAD, s], r[block, a, REST, s]
            stays = 1.0 if new > 0.0 else 0.0
            back = (1.0 - stays) * (1.0 if left > max(1e-15 * (abs(free) + rise), 1e-18) else 0.0)
            new += 1.0 - stays
            step = stays * (new - f) / f + (1.0 - stays) * max(r[block, a, ON, s], back)
            log = r[block, a, LOG, s] + log_of_growth(step)
            deepest += stays * (1.0 if log + 1.0 > r[block, a, OFFSET, s] else 0.0) + 1.0 - r[block, a, BEYOND, s]
            r[block, a, RETURNED, s] = back * left
            r[block, a, LOAD, s], r[block, a, LOG, s], r[block, a, ON, s] = new, log, stays
            bent = slope * new + r[block, a, BEND, s] * (1.0 if new * r[block, a, PER_WHOLE, s] < 1.0 else 0.0)
            force += face[block, WIDTH, s] * r[block, a, PHI, s] * new * stays
            bend += face[block, WIDTH, s] * r[block, a, STIFFNESS + PAIR_FIELDS * a, s] * step * step * bent
            total += step * step
            returned += back
    if returned > 0.0:
        _take_back(slope, block, rows, r)
    if total > SERIES * SERIES:
        for a in range(rows):
            logarithm(r[block, a], bits[block, a], LOAD, LOG, REST)
    if deepest > 0.0 and slope > 0.0:
        for a in range(rows):
            for s in range(LANES):
                r[block, a, BEYOND, s] = hertz_validity(r[block, a, OFFSET, s] - r[block, a, LOG, s])
    return force, 0.5 * bend, total


@inner()
def _take_back(slope, block, rows, r):
    """A first load for the pairs that return: those in whose row RETURNED the approach to the least gap is."""
    for a in range(rows):
        for s in range(LANES):
            if r[block, a, RETURNED, s] > 0.0:
                rise, even = r[block, a, RISE, s], r[block, a, EVEN, s]
                whole = touch(r[block, a, RETURNED, s] - rise, rise, even)
                r[block, a, LOAD, s] = whole / (r[block, a, SOFTNESS, s] + 0.8 * slope * r[block, a, OFFSET, s])
                r[block, a, ON, s] = 1.0


@njit(**SPREAD)
def _settle_in_turn(law, rows, modes, r, small, shares):
    """Slices exactly at held displacements, then those by a Newton step, in turn, in halves later; the stiffnesses."""
    scale, last = 0.0, small.shape[1] - 1
    stiffness = 0.0, 0.0, 0.0
    for i in range(modes + BODIES):
        shares[i] = 0.0
    for block in range(r.shape[0]):
        for a in range(rows):
            for s in range(LANES):
                r[block, a, MOVED, s] = r[block, a, FIELD, s] = 0.0
    for step in range(EXACT_STEPS):
        for block in range(r.shape[0]):
            for s in range(LANES):
                for a in range(rows):
                    r[block, a, MOVED_BEFORE, s] = r[block, a, MOVED, s]
                    r[block, a, FIELD_BEFORE, s] = r[block, a, FIELD, s]
                _descend(law.slope, block, s, rows, r)
        _, _, stiffness = newton_step(law, rows, modes, r, small)
        largest = 0.0
        for block in range(r.shape[0]):
            for a in range(rows):
                for s in range(LANES):
                    largest = max(largest, abs(r[block, a, MOVED, s] - r[block, a, MOVED_BEFORE, s]))
        scale = max(scale, largest)
        part = 1.0 if step < 8 or largest <= 1e-3 * scale else 0.5
        for i in range(modes + BODIES):
            shares[i] += part * (small[i, last] - shares[i])
        for block in range(r.shape[0]):
            for a in range(rows):
                for s in range(LANES):
                    before, field = r[block, a, MOVED_BEFORE, s], r[block, a, FIELD_BEFORE, s]
                    r[block, a, MOVED, s] = before + part * (r[block, a, MOVED, s] - before)
                    r[block, a, FIELD, s] = field + part * (r[block, a, FIELD, s] - field)
        if largest <= EXACT_CLOSE * scale:
            break
    for i in range(modes + BODIES):
        small[i, last] = shares[i]
    return stiffness


@inner()
def _descend(slope, block, s, rows, r):
    """Loads of one slice for any number of pairs, any sign of what neighbours add, any approach."""
    for a in range(rows):
        r[block, a, LOAD, s] = r[block, a, ON, s] = 0.0
    for _ in range(1000):
        change = largest = 0.0
        for a in range(rows):
            x, before = r[block, a, FREE, s] - r[block, a, MOVED, s], r[block, a, ON, s] * r[block, a, LOAD, s]
            for b in range(rows):
                if b != a:
                    pushed = r[block, b, PHI, s] * r[block, b, ON, s] * r[block, b, LOAD, s]
                    x -= r[block, a, COUPLED + PAIR_FIELDS * b, s] * pushed
            f = log = 0.0
            if x + r[block, a, RISE, s] > 0.0:
                part = r[block, a, RISE, s], r[block, a, PER_WHOLE, s], r[block, a, EVEN, s]
                f, log = single_load(x, r[block, a, SOFTNESS, s], slope, r[block, a, OFFSET, s], part)
            on = f > 0.0
            r[block, a, LOAD, s], r[block, a, LOG, s], r[block, a, ON, s] = f if on else 1.0, log, 1.0 if on else 0.0
            r[block, a, BEYOND, s] = hertz_validity(r[block, a, OFFSET, s] - log) if on and slope > 0.0 else 1.0
            change, largest = max(change, abs(f - before)), max(largest, f)
        if change <= 1e-13 * largest:
            break


@inner(**INLINE)
def _covered(face, delta, psi, small):
    """True if the bodies bring no slice closer than its free approach, for which the pairs were gathered."""
    least = 0.0
    d, t = small[0, small.shape[1] - 1], small[1, small.shape[1] - 1]
    for block in range(len(face)):
        for s in range(LANES):
            least = min(least, d + t * face[block, Y, s] + 1e-14 * abs(delta + psi * face[block, Y, s]))
    return least >= 0.0


@inner()
def _least_move(law, own_cycle, teeth, small):
    """The least displacement (m) by which bodies and modes relieve any pair that may touch."""
    least, last = math.inf, small.shape[1] - 1
    for number in range(int(law.slices)):
        block, s = number // LANES, number % LANES
        move = small[0, last] + small[1, last] * law.block[block, Y, s]
        here = own_cycle + law.block[block, SHIFT, s]
        least = min(least, move)
        for p in range(math.ceil(here - law.start - law.cells / law.per_step), math.floor(here - law.start) + 1):
            cell, u = cell_of(law, max((here - p - law.start) * law.per_step, 0.0))
            taken, at = move, BODIES
            for i in range(len(teeth)):
                for k in range(int(law.pinion_modes if teeth[i, 1] == 0.0 else law.wheel_modes)):
                    low, high = mode_at(law, teeth[i], p, number, cell, k)
                    taken += small[at, last] * (low + u * (high - low))
                    at += 1
            least = min(least, taken)
    return least


@njit(**SPREAD)
def _sums(law, own_cycle, rows, modes, r, small, stiffness, loads):
    """The answer of solved slices; with their line loads if `loads` has room, see `respond`."""
    force = moment = energy = 0.0
    for block in range(r.shape[0]):
        sums = _block_sums(law.slope, law.block, block, rows, r)
        force, moment, energy = force + sums[0], moment + sums[1], energy + sums[2]
    for i in range(modes + BODIES):
        share = small[i, small.shape[1] - 1]
        energy += 0.5 * share * (force if i == 0 else (moment if i == 1 else share))
    if loads.size > 0:
        _keep_loads(math.floor(own_cycle), rows, r, loads)
    return force, moment, energy, stiffness[0], stiffness[1], stiffness[2]


@inner(**SUMS)
def _block_sums(slope, face, block, rows, r):
    """F, M and U of the slices of a block, with half the work of their fields."""
    force = moment = energy = 0.0
    for s in range(LANES):
        w, y = face[block, WIDTH, s], face[block, Y, s]
        for a in range(rows):
            f, depth = r[block, a, ON, s] * r[block, a, LOAD, s], r[block, a, OFFSET, s] - r[block, a, LOG, s]
            rise, even, t = r[block, a, RISE, s], r[block, a, EVEN, s], r[block, a, BEYOND, s]
            part = part_of(f, r[block, a, PER_WHOLE, s], even)
            bent = slope * (max(depth, 1.0) + 0.5 + 2.0 * (t - 0.25 * t * t - 0.75))
            left = r[block, a, FREE, s] - r[block, a, MOVED, s] + 0.5 * r[block, a, GAIN, s] * r[block, a, FIELD, s]
            own = left * f - 0.5 * f * f * (r[block, a, SOFTNESS, s] + bent)
            own += rise / r[block, a, PER_WHOLE, s] * reduction_of_work(even, part)
            load = w * r[block, a, PHI, s] * f
            force += load
            moment += load * y
            energy += w * r[block, a, PHI, s] * own
            for b in range(a + 1, rows):
                other = r[block, b, ON, s] * r[block, b, PHI, s] * r[block, b, LOAD, s]
                energy -= r[block, a, COUPLED + PAIR_FIELDS * b, s] * load * other
    return force, moment, energy


@inner()
def _keep_loads(anchor, rows, r, loads):
    """Line loads phi f where a pair carries."""
    places, slices = loads.shape
    for block in range(r.shape[0]):
        for a in range(rows):
            for s in range(LANES):
                place, number = int(r[block, a, PAIR, s]) - anchor + places // 2, block * LANES + s
                if r[block, a, ON, s] > 0.0 and number < slices and 0 <= place < places:
                    loads[place, number] = r[block, a, PHI, s] * r[block, a, LOAD, s]
