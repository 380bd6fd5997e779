"""The linear problem of one Newton step of the mesh law, compiled: slices, then fields, then modes, then bodies.

Let l = f + J^-1 r be the loads after a Newton step of every slice by itself at the free approach, where fields, bodies
and modes take nothing from it. With them they are f = l - J^-1 (g v + sum_k c_k z_k), where c_0 = 1 and c_1 = y belong
to the bodies z = (d, t) and all further c_k to modes. With K = phi J^-1 the step reads

    A v = b_l - sum_k z_k b_k,   A = T + w g K g,   b_l = w g phi l,   b_k = w g K c_k
    h_i - sum_k k_ik z_k  is the force on displacement i,  h_i = sum w c_i phi l - b_i' A^-1 b_l,
                                                           k_ij = sum w c_i K c_j - b_i' A^-1 b_j
    z_k = that force for a mode,  (d, t) = E times those of the bodies

A is tridiagonal in blocks of the pairs of a slice; it is eliminated from both ends of the face to its middle, which two
chains of operations do at the same time.
"""

from __future__ import annotations

from numba import njit

from fem.contact.evaluation.law_tables import LANES, WIDTH, Y
from fem.contact.evaluation.line_contact import compliance_of, hertz_depth
from fem.contact.evaluation.slice_contacts import (
    BEYOND,
    BODIES,
    COUPLED,
    EVEN,
    FIELD,
    FREE,
    FROM_BODY,
    FROM_LOAD,
    FROM_TILT,
    GAIN,
    LINK,
    LOAD,
    LOG,
    MODE,
    MODE_FROM,
    MODE_RIGHT,
    MOVED,
    OFFSET,
    ON,
    PAIR_FIELDS,
    PER_WHOLE,
    PHI,
    PIVOT,
    REST,
    RIGHT_BODY,
    RIGHT_LOAD,
    RIGHT_TILT,
    RISE,
    SOFTNESS,
    STAY,
    STIFFNESS,
    SYSTEM,
    TARGET,
    mode_field,
)
from fem.contact.part_contact import part_of, reduction_of, reduction_of_compliance
from fem.numerics.compiled import SPREAD, SUMS
from fem.numerics.inner_functions import INLINE, inner


@njit(**SPREAD)
def newton_step(law, rows, modes, r, small):
    """Fields, bodies and modes after a step from the loads there are; d, t and the stiffnesses k00, k01, k11.

    Parameters
    ----------
    law : `LawTables`
    rows, modes : numbers; literals where the compiler may unroll loops over them
    r : all fields, see `contacts`
    small : (modes + 2, modes + 4) the modes' k (row, column) with the bodies in front; out: column -1 their shares q,
        of the bodies d and t
    """
    force = moment = k = mixed = tilt = 0.0
    for i in range(modes + BODIES if modes > 0 else 0):
        for j in range(modes + BODIES + 2):
            small[i, j] = 0.0
    for block in range(r.shape[0]):
        sums = _linearise(law.slope, law.block, block, rows, modes, r)
        force, moment, k, mixed, tilt = force + sums[0], moment + sums[1], k + sums[2], mixed + sums[3], tilt + sums[4]
        if modes > 0:
            _add_modes(law.block, block, rows, modes, r, small)
    if law.spread_length > 0.0:
        sums = _eliminate(int(law.slices), rows, modes, r, small)
        force, moment, k, mixed, tilt = force - sums[0], moment - sums[1], k - sums[2], mixed - sums[3], tilt - sums[4]
    stiffness = k, mixed, tilt
    if modes > 0:
        force, moment, stiffness = _modes_in_series(modes, force, moment, stiffness, small)
    d, t, stiffness = bodies_in_series(law.body, law.skew, law.tilt, force, moment, stiffness)
    _move(law.block, int(law.slices), law.spread_length > 0.0, rows, modes, r, _shares(modes, d, t, small))
    return d, t, stiffness


@inner(**SUMS)
def _linearise(slope, face, block, rows, modes, r):
    """phi l, K and the field equations of a block; the sums of w phi l, w y phi l, w K, w y K and w y^2 K."""
    force = moment = k = mixed = tilt = 0.0
    for s in range(LANES):
        w, y = face[block, WIDTH, s], face[block, Y, s]
        for a in range(rows):
            f, depth, even = r[block, a, LOAD, s], r[block, a, OFFSET, s] - r[block, a, LOG, s], r[block, a, EVEN, s]
            soft, rise, per_whole = r[block, a, SOFTNESS, s], r[block, a, RISE, s], r[block, a, PER_WHOLE, s]
            part = part_of(f, per_whole, even)
            rest = r[block, a, FREE, s] - f * (soft + slope * hertz_depth(depth, r[block, a, BEYOND, s]))
            rest += rise * reduction_of(even, part)
            for b in range(rows):
                if b != a:
                    both = r[block, a, ON, s] * r[block, b, ON, s]
                    pull = both * r[block, a, COUPLED + PAIR_FIELDS * b, s] * r[block, b, PHI, s]
                    r[block, a, SYSTEM + PAIR_FIELDS * b, s] = pull
                    rest -= pull * r[block, b, LOAD, s]
            own = compliance_of(soft, slope, depth) + rise * per_whole * reduction_of_compliance(even, part)
            r[block, a, SYSTEM + PAIR_FIELDS * a, s] = own
            r[block, a, REST, s] = r[block, a, ON, s] * rest
        _invert(block, s, rows, SYSTEM, r)
        for a in range(rows):
            on, g = r[block, a, ON, s] * r[block, a, PHI, s], r[block, a, GAIN, s]
            target, total = r[block, a, LOAD, s], 0.0
            for b in range(rows):
                inverse = r[block, a, SYSTEM + PAIR_FIELDS * b, s]
                target += inverse * r[block, b, REST, s]
                stiffness = on * inverse * r[block, b, ON, s]
                total += stiffness
                r[block, a, STIFFNESS + PAIR_FIELDS * b, s] = stiffness
                stay = r[block, a, STAY, s] if a == b else 0.0
                r[block, a, PIVOT + PAIR_FIELDS * b, s] = w * g * r[block, b, GAIN, s] * stiffness + stay
            r[block, a, TARGET, s] = target
            load, stiff = w * on * target, w * total
            r[block, a, RIGHT_LOAD, s], r[block, a, RIGHT_BODY, s] = g * load, g * stiff
            r[block, a, RIGHT_TILT, s] = g * stiff * y
            force += load
            moment += load * y
            k += stiff
            mixed += stiff * y
            tilt += stiff * y * y
    return force, moment, k, mixed, tilt


@inner(**INLINE)
def _invert(block, s, rows, kind, r):
    """Inverse of a matrix of pairs (SYSTEM or PIVOT) of lane s in place, without pivoting."""
    if rows == 2:
        a, b = r[block, 0, kind + PAIR_FIELDS * 0, s], r[block, 0, kind + PAIR_FIELDS * 1, s]
        c, d = r[block, 1, kind + PAIR_FIELDS * 0, s], r[block, 1, kind + PAIR_FIELDS * 1, s]
        scale = 1.0 / (a * d - b * c)
        r[block, 0, kind + PAIR_FIELDS * 0, s], r[block, 0, kind + PAIR_FIELDS * 1, s] = d * scale, -b * scale
        r[block, 1, kind + PAIR_FIELDS * 0, s], r[block, 1, kind + PAIR_FIELDS * 1, s] = -c * scale, a * scale
        return
    for k in range(rows):
        pivot = 1.0 / r[block, k, kind + PAIR_FIELDS * k, s]
        r[block, k, kind + PAIR_FIELDS * k, s] = 1.0
        for j in range(rows):
            r[block, k, kind + PAIR_FIELDS * j, s] *= pivot
        for i in range(rows):
            if i != k:
                factor = r[block, i, kind + PAIR_FIELDS * k, s]
                r[block, i, kind + PAIR_FIELDS * k, s] = 0.0
                for j in range(rows):
                    r[block, i, kind + PAIR_FIELDS * j, s] -= factor * r[block, k, kind + PAIR_FIELDS * j, s]


@inner(**INLINE)
def _add_modes(face, block, rows, modes, r, small):
    """The block's part of k and h of the modes, and their right sides of the field equations."""
    last = modes + BODIES
    for m in range(modes):
        own, right = mode_field(rows, m, MODE), mode_field(rows, m, MODE_RIGHT)
        for s in range(LANES):
            for a in range(rows):
                total = 0.0
                for b in range(rows):
                    total += r[block, a, STIFFNESS + PAIR_FIELDS * b, s] * r[block, b, own, s]
                total *= face[block, WIDTH, s]
                r[block, a, right, s] = r[block, a, GAIN, s] * total
                small[0, BODIES + m] += total
                small[1, BODIES + m] += total * face[block, Y, s]
                load = r[block, a, ON, s] * r[block, a, PHI, s] * r[block, a, TARGET, s]
                small[BODIES + m, last] += face[block, WIDTH, s] * r[block, a, own, s] * load
                for other in range(m + 1):
                    small[BODIES + other, BODIES + m] += r[block, a, mode_field(rows, other, MODE), s] * total


@inner(**INLINE)
def _eliminate(count, rows, modes, r, small):
    """Eliminate the fields of `count` slices; what the bodies' sums lose, in the order of `_linearise`."""
    middle, sums = count // 2, (0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(middle + 1):
        for s, to in ((i, i + 1), (count - 1 - i, count - 2 - i)):
            if (i < middle and s != middle) or (i == middle and s < to):
                block, lane = s // LANES, s % LANES
                sums = _pivot(block, lane, rows, modes, r, small, sums)
                if s != middle:
                    _pass_on(s, to, rows, modes, r)
    return sums


@inner(**INLINE)
def _pivot(block, s, rows, modes, r, small, sums):
    """Invert the pivot of lane s, solve it for all right sides, add their products to the sums and take them off k."""
    _invert(block, s, rows, PIVOT, r)
    t0, t1, t2, t3, t4 = sums
    for a in range(rows):
        x = y = z = 0.0
        for b in range(rows):
            inverse = r[block, a, PIVOT + PAIR_FIELDS * b, s]
            x += inverse * r[block, b, RIGHT_LOAD, s]
            y += inverse * r[block, b, RIGHT_BODY, s]
            z += inverse * r[block, b, RIGHT_TILT, s]
        p, q = r[block, a, RIGHT_BODY, s], r[block, a, RIGHT_TILT, s]
        t0, t1, t2, t3, t4 = t0 + p * x, t1 + q * x, t2 + p * y, t3 + p * z, t4 + q * z
        r[block, a, FROM_LOAD, s], r[block, a, FROM_BODY, s], r[block, a, FROM_TILT, s] = x, y, z
    for m in range(modes):
        right = mode_field(rows, m, MODE_RIGHT)
        for a in range(rows):
            x, own = 0.0, r[block, a, right, s]
            for b in range(rows):
                x += r[block, a, PIVOT + PAIR_FIELDS * b, s] * r[block, b, right, s]
            r[block, a, mode_field(rows, m, MODE_FROM), s] = x
            small[BODIES + m, BODIES + modes] -= own * r[block, a, FROM_LOAD, s]
            small[0, BODIES + m] -= own * r[block, a, FROM_BODY, s]
            small[1, BODIES + m] -= own * r[block, a, FROM_TILT, s]
            for other in range(m + 1):
                small[BODIES + other, BODIES + m] -= r[block, a, mode_field(rows, other, MODE_RIGHT), s] * x
    return t0, t1, t2, t3, t4


@inner(**INLINE)
def _pass_on(one, other, rows, modes, r):
    """What the eliminated slice `one` leaves to the next one."""
    block, s, to, lane = one // LANES, one % LANES, other // LANES, other % LANES
    at, between = (block, s) if one < other else (to, lane)
    for a in range(rows):
        link = r[at, a, LINK, between]
        for b in range(rows):
            r[to, a, PIVOT + PAIR_FIELDS * b, lane] -= (
                link * r[at, b, LINK, between] * r[block, a, PIVOT + PAIR_FIELDS * b, s]
            )
        r[to, a, RIGHT_LOAD, lane] += link * r[block, a, FROM_LOAD, s]
        r[to, a, RIGHT_BODY, lane] += link * r[block, a, FROM_BODY, s]
        r[to, a, RIGHT_TILT, lane] += link * r[block, a, FROM_TILT, s]
        for m in range(modes):
            r[to, a, mode_field(rows, m, MODE_RIGHT), lane] += link * r[block, a, mode_field(rows, m, MODE_FROM), s]


@inner(**INLINE)
def _modes_in_series(modes, force, moment, stiffness, small):
    """Force, moment and stiffnesses of the bodies with the modes, which have a unit compliance, in series.

    Eliminated from the last to the first; the upper triangle of `small` keeps what `_shares` needs.
    """
    n = modes + BODIES
    small[0, 0], small[0, 1], small[1, 1] = stiffness
    small[0, n], small[1, n] = force, moment
    for m in range(n - 1, 1, -1):
        pivot = 1.0 / (1.0 + small[m, m])
        for i in range(m):
            factor = small[i, m] * pivot
            small[i, n] -= factor * small[m, n]
            for j in range(i + 1):
                small[j, i] -= factor * small[j, m]
    return small[0, n], small[1, n], (small[0, 0], small[0, 1], small[1, 1])


@inner(**INLINE)
def bodies_in_series(body, skew, tilt, force, moment, stiffness):
    """d, t of (d, t) = E ((F, M) - k (d, t)), in m and rad, and the stiffnesses k with the bodies E in series.

    Parameters
    ----------
    body, skew, tilt : E_0 (m/N), E_01 (1/N) and E_1 (1/(N m))
    force, moment : F (N) and M (N m) at d = t = 0
    stiffness : k00, k01, k11, dF/d delta (N/m), dF/d psi = dM/d delta (N) and dM/d psi (N m) at held bodies
    """
    k00, k01, k11 = stiffness
    a00, a01 = 1.0 + body * k00 + skew * k01, body * k01 + skew * k11
    a10, a11 = skew * k00 + tilt * k01, 1.0 + skew * k01 + tilt * k11
    r0, r1 = body * force + skew * moment, skew * force + tilt * moment
    scale = 1.0 / (a00 * a11 - a01 * a10)
    d, t = (a11 * r0 - a01 * r1) * scale, (a00 * r1 - a10 * r0) * scale
    return d, t, ((k00 * a11 - k01 * a10) * scale, (k01 * a00 - k00 * a01) * scale, (k11 * a00 - k01 * a01) * scale)


@inner(**INLINE)
def _shares(modes, d, t, small):
    """`small` with d, t and the shares q of the modes in its last column."""
    n, last = modes + BODIES, small.shape[1] - 1
    small[0, last], small[1, last] = d, t
    for m in range(BODIES, n):
        share = small[m, n]
        for i in range(m):
            share -= small[i, m] * small[i, last]
        small[m, last] = share / (1.0 + small[m, m])
    return small


@inner(**INLINE)
def _move(face, count, spread, rows, modes, r, small):
    """Fields, from the middle to both ends, and what fields, bodies and modes take from the approaches."""
    last = small.shape[1] - 1
    d, t = small[0, last], small[1, last]
    for block in range(r.shape[0]):
        for s in range(LANES):
            for a in range(rows):
                moved = d + t * face[block, Y, s]
                for m in range(modes):
                    moved += small[BODIES + m, last] * r[block, a, mode_field(rows, m, MODE), s]
                r[block, a, MOVED, s] = moved
    if spread:
        for block in range(r.shape[0]):
            for s in range(LANES):
                for a in range(rows):
                    v = r[block, a, FROM_LOAD, s] - d * r[block, a, FROM_BODY, s] - t * r[block, a, FROM_TILT, s]
                    for m in range(modes):
                        v -= small[BODIES + m, last] * r[block, a, mode_field(rows, m, MODE_FROM), s]
                    r[block, a, FIELD, s] = v
        middle = count // 2
        for i in range(1, middle + 1):
            for s, inner_s in ((middle - i, middle - i + 1), (middle + i, middle + i - 1)):
                if s < count:
                    block, lane, of, at = s // LANES, s % LANES, inner_s // LANES, inner_s % LANES
                    linked, between = (block, lane) if s < inner_s else (of, at)
                    for a in range(rows):
                        v = r[block, a, FIELD, lane]
                        for b in range(rows):
                            passed = r[linked, b, LINK, between] * r[of, b, FIELD, at]
                            v += r[block, a, PIVOT + PAIR_FIELDS * b, lane] * passed
                        r[block, a, FIELD, lane] = v
        for block in range(r.shape[0]):
            for s in range(LANES):
                for a in range(rows):
                    r[block, a, MOVED, s] += r[block, a, GAIN, s] * r[block, a, FIELD, s]
