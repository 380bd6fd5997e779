"""Fields of tooth bending along the face, compiled: the arrays of a block of slices, and which slices one line links.

The line of pair p is its trace over the face; its field v_p obeys the equation in `fem.contact.law`. Row a holds the
lines of all pairs p with p mod rows = a, one behind the other along the face. The part of a line before its first and
behind its last slice acts like one spring (`before` and `behind` of `fem.contact.evaluation.law_tables.Slices`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from fem.contact.evaluation.law_tables import LANES, slices_of
from fem.contact.evaluation.slice_rows import NEVER, cell_of, gather, invert, rows_in, rows_room
from fem.numerics.compiled import INLINE, SPREAD, inner, views


class FieldRows(NamedTuple):
    """Arrays (row, lane), or as noted."""

    order: tuple[int, ...]  # as in `Rows`
    widest: np.ndarray  # free approach that belongs to the larger of two states, m
    free: np.ndarray  # free approach of the state, m
    gain: np.ndarray  # g = sqrt(D)
    gain_slope: np.ndarray
    field: np.ndarray  # v
    before: np.ndarray  # v before the last step
    link: np.ndarray  # spring to the next slice nearer the middle of the face, m; 0 where another line lies there
    stay: np.ndarray  # width and springs of a slice, m
    target: np.ndarray  # phi l: loads after a Newton step of the slice by itself
    by_load: np.ndarray  # right-hand sides w g phi l, w g K 1 and w g K y
    by_approach: np.ndarray
    by_tilt: np.ndarray
    from_load: np.ndarray  # their parts of v while the slices nearer the middle are held
    from_approach: np.ndarray
    from_tilt: np.ndarray
    stiffness: np.ndarray  # (row, row, lane) K = phi J^-1 of the slice
    inverse: np.ndarray  # (row, row, lane) matrix of the field equations, then the inverse of its pivot


@inner(**INLINE)
def face_room(blocks, n):
    """Numbers of memory for all blocks of the face with n rows."""
    return blocks * (rows_room(n) + (15 * n + 2 * n * n) * LANES)


@inner(**INLINE)
def block_rows(memory, block):
    """`Rows` of a block; memory: numbers (k,), the place of the first block in them, the order of the rows."""
    numbers, at, order = memory
    return rows_in(numbers, at + face_room(block, len(order)), order)


@inner(**INLINE)
def field_rows(memory, block):
    """`FieldRows` of a block."""
    numbers, at, order = memory
    n = len(order)
    at += face_room(block, n) + rows_room(n)
    by_row, by_pair = views(numbers, at, 15, (n, LANES)), views(numbers, at + 15 * n * LANES, 2, (n, n, LANES))
    return FieldRows(order, *(by_row + by_pair))


@inner(**INLINE)
def gather_face(law, near, own_cycle, states, lowest, memory):
    """`gather` for all blocks, with their fields; returns the rows needed, in the manner of `gather`.

    Parameters
    ----------
    law, near, own_cycle, states, lowest : as for `gather`
    memory : as for `block_rows`, out
    """
    found, n = 0, len(memory[2])
    for block in range(len(law.block)):
        rows, fields = block_rows(memory, block), field_rows(memory, block)
        needed = gather(law, near, block, own_cycle, states, lowest, rows)
        found = max(found, needed)
        if needed > n:
            break
        for a in range(n):
            for s in range(LANES):
                g = steep = 0.0
                if law.spread_length > 0.0 and rows.approach[a, s] > NEVER:
                    cell, u = cell_of(law, rows.place[a, s])
                    g, steep = law.gain[cell, 0] + u * law.gain[cell, 1], law.gain[cell, 1] * law.per_step
                fields.gain[a, s], fields.gain_slope[a, s] = g, steep
                fields.widest[a, s] = rows.approach[a, s]
                fields.field[a, s] = fields.link[a, s] = fields.stay[a, s] = 0.0
    if found == n and law.spread_length > 0.0 and not _link(law, memory):
        return n + 1
    return found


@inner(**INLINE)
def _link(law, memory):
    """Springs between the slices that one line runs through; False where a line comes back after another."""
    good, count = True, int(law.slices)
    for a in range(len(memory[2])):
        last, number, direction = -1, 0.0, 0.0
        for s in range(count):
            rows = block_rows(memory, s // LANES)
            if rows.approach[a, s % LANES] > NEVER:
                found = rows.pair[a, s % LANES]
                if last >= 0 and found == number:
                    for j in range(last, s):
                        field_rows(memory, j // LANES).link[a, j % LANES] = slices_of(law, j // LANES).spring[j % LANES]
                elif last >= 0:
                    good = good and direction * (found - number) >= 0.0
                    direction = found - number
                last, number = s, found
        behind = 0.0
        for s in range(count):
            slices, fields, lane = slices_of(law, s // LANES), field_rows(memory, s // LANES), s % LANES
            ahead = fields.link[a, lane]
            stay = slices.width[lane] + (behind if behind > 0.0 else slices.before[lane])
            fields.stay[a, lane] = stay + (ahead if ahead > 0.0 else slices.behind[lane])
            fields.link[a, lane] = ahead if s < count // 2 else behind
            behind = ahead
    return good


@inner(**INLINE)
def in_series(law, k, force, moment):
    """d, t of (d, t) = E ((F, M) - k (d, t)), in m and rad, and the stiffnesses k with the bodies E in series.

    Parameters
    ----------
    law : `LawTables`
    k : k00, k01, k11, dF/d delta (N/m), dF/d psi = dM/d delta (N) and dM/d psi (N m) at held bodies
    force, moment : F (N) and M (N m) at d = t = 0
    """
    k00, k01, k11 = k
    a00, a01 = 1.0 + law.body * k00 + law.skew * k01, law.body * k01 + law.skew * k11
    a10, a11 = law.skew * k00 + law.tilt * k01, 1.0 + law.skew * k01 + law.tilt * k11
    r0, r1 = law.body * force + law.skew * moment, law.skew * force + law.tilt * moment
    scale = 1.0 / (a00 * a11 - a01 * a10)
    d, t = (a11 * r0 - a01 * r1) * scale, (a00 * r1 - a10 * r0) * scale
    return d, t, ((k00 * a11 - k01 * a10) * scale, (k01 * a00 - k00 * a01) * scale, (k11 * a00 - k01 * a01) * scale)


@njit(**SPREAD)
def eliminate(count, memory):
    """Eliminate the `count` slices from both ends; p' A^-1 r, q' A^-1 r, p' A^-1 p, p' A^-1 q, q' A^-1 q.

    memory: as for `block_rows`.
    """
    middle, sums = count // 2, (0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(middle):
        for s, inner_s in ((i, i + 1), (count - 1 - i, count - 2 - i)):
            if s != middle:
                sums = _pivot(field_rows(memory, s // LANES), s % LANES, sums)
                _pass_on(
                    field_rows(memory, s // LANES), s % LANES, field_rows(memory, inner_s // LANES), inner_s % LANES
                )
    return _pivot(field_rows(memory, middle // LANES), middle % LANES, sums)


@inner(**INLINE)
def _pivot(f, s, sums):
    """Invert the pivot of lane s and solve it for the three right-hand sides; adds its five inner products."""
    n = len(f.order)
    invert(f.order, f.inverse, s)
    t0, t1, t2, t3, t4 = sums
    for a in range(n):
        x = y = z = 0.0
        for b in range(n):
            x += f.inverse[a, b, s] * f.by_load[b, s]
            y += f.inverse[a, b, s] * f.by_approach[b, s]
            z += f.inverse[a, b, s] * f.by_tilt[b, s]
        p, q = f.by_approach[a, s], f.by_tilt[a, s]
        t0, t1, t2, t3, t4 = t0 + p * x, t1 + q * x, t2 + p * y, t3 + p * z, t4 + q * z
        f.from_load[a, s], f.from_approach[a, s], f.from_tilt[a, s] = x, y, z
    return t0, t1, t2, t3, t4


@inner(**INLINE)
def _pass_on(f, s, g, lane):
    """What the eliminated slice in lane s of the fields f leaves to the next slice, in `lane` of g."""
    for a in range(len(f.order)):
        link = f.link[a, s]
        for b in range(len(f.order)):
            g.inverse[a, b, lane] -= link * f.link[b, s] * f.inverse[a, b, s]
        g.by_load[a, lane] += link * f.from_load[a, s]
        g.by_approach[a, lane] += link * f.from_approach[a, s]
        g.by_tilt[a, lane] += link * f.from_tilt[a, s]


@njit(**SPREAD)
def substitute(count, d, t, memory):
    """The fields at given body displacements, from the middle to both ends.

    Parameters
    ----------
    count, memory : as for `eliminate`, which goes before
    d, t : body displacements, m and rad
    """
    middle = count // 2
    for i in range(middle + 1):
        for s, inner_s in ((middle - i, middle - i + 1), (middle + i, middle + i - 1)):
            if s < count:
                _field(
                    field_rows(memory, s // LANES),
                    s % LANES,
                    field_rows(memory, inner_s // LANES),
                    inner_s % LANES,
                    d,
                    t,
                    i,
                )


@inner(**INLINE)
def _field(f, s, g, lane, d, t, i):
    """The field in lane s of f from that of the slice nearer the middle, in `lane` of g, if there is one (i > 0)."""
    for a in range(len(f.order)):
        v = f.from_load[a, s] - d * f.from_approach[a, s] - t * f.from_tilt[a, s]
        for b in range(len(f.order) if i > 0 else 0):
            v += f.inverse[a, b, s] * f.link[b, s] * g.field[b, lane]
        f.field[a, s] = v
