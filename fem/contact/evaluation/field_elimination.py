"""Two fields along the face and two body displacements: elimination of one linear problem of `coupled_newton`.

(A - springs) v = R - d P - t y P, in blocks of 2 x 2 along the slices, and (d, t) = E (F, M) with F, M and their
stiffnesses less what the fields take. With the eliminated right-hand sides r, p, q of a slice and its pivot S, the sums
of p' S^-1 r, q' S^-1 r, ... over the slices are those inner products with A^-1, so that d and t are known before
anything is substituted back.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from fem.contact.evaluation.coupled_newton import A00, A01, A11, FIELD, LINK, P0, P1, RIGHT, TOTAL, Z0, Z1
from fem.contact.evaluation.packing import BODY, LANES, ROWS_PER_BLOCK, SKEW, SLICE_ROWS, TILT, Y
from fem.numerics.compiled import PLAIN

_inline: dict[str, Any] = {"forceinline": True, "fastmath": {"contract"}}


@njit(**PLAIN, **_inline)
def in_series(tables, k00, k01, k11, force, moment):
    """d, t of (d, t) = E (F - k d, M - k t) and the stiffnesses k00, k01, k11 with the bodies E in series."""
    e0, e01, e1 = tables[BODY], tables[SKEW], tables[TILT]
    a00, a01 = 1.0 + e0 * k00 + e01 * k01, e0 * k01 + e01 * k11
    a10, a11 = e01 * k00 + e1 * k01, 1.0 + e01 * k01 + e1 * k11
    r0, r1 = e0 * force + e01 * moment, e01 * force + e1 * moment
    scale = 1.0 / (a00 * a11 - a01 * a10)
    d, t = (a11 * r0 - a01 * r1) * scale, (a00 * r1 - a10 * r0) * scale
    return d, t, (k00 * a11 - k01 * a10) * scale, (k01 * a00 - k00 * a01) * scale, (k11 * a00 - k01 * a01) * scale


@njit(**PLAIN, **_inline)
def eliminate(tables, n_s, work):
    """Eliminate from both ends to the middle; p' A^-1 r, q' A^-1 r, p' A^-1 p, p' A^-1 q, q' A^-1 q."""
    middle = n_s // 2
    t0 = t1 = t2 = t3 = t4 = 0.0
    left = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    right = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(middle):
        top, lane = (i // LANES) * TOTAL, i % LANES
        left, sums = _pivot(tables, i, work, left, work[top + LINK, lane], work[top + LINK + 1, lane])
        t0, t1, t2, t3, t4 = t0 + sums[0], t1 + sums[1], t2 + sums[2], t3 + sums[3], t4 + sums[4]
        j = n_s - 1 - i
        if j > middle:
            top, lane = ((j - 1) // LANES) * TOTAL, (j - 1) % LANES
            right, sums = _pivot(tables, j, work, right, work[top + LINK, lane], work[top + LINK + 1, lane])
            t0, t1, t2, t3, t4 = t0 + sums[0], t1 + sums[1], t2 + sums[2], t3 + sums[3], t4 + sums[4]
    both = (
        left[0] + right[0],
        left[1] + right[1],
        left[2] + right[2],
        left[3] + right[3],
        left[4] + right[4],
        left[5] + right[5],
        left[6] + right[6],
        left[7] + right[7],
        left[8] + right[8],
    )
    _, sums = _pivot(tables, middle, work, both, 0.0, 0.0)
    return t0 + sums[0], t1 + sums[1], t2 + sums[2], t3 + sums[3], t4 + sums[4]


@njit(**PLAIN, **_inline)
def _pivot(tables, s, work, taken, link0, link1):
    """Eliminate slice s; what it hands to the slice behind the springs link0, link1, and its five inner products."""
    top, lane = (s // LANES) * TOTAL, s % LANES
    y = tables[SLICE_ROWS + ((s // LANES) * ROWS_PER_BLOCK + Y) * LANES + lane]
    a, b, c = work[top + A00, lane] - taken[0], work[top + A01, lane] - taken[1], work[top + A11, lane] - taken[2]
    scale = 1.0 / (a * c - b * b)
    i00, i01, i11 = c * scale, -b * scale, a * scale
    p0, p1 = work[top + P0, lane], work[top + P1, lane]
    q0, q1 = y * p0 + taken[7], y * p1 + taken[8]
    r0, r1 = work[top + RIGHT, lane] + taken[3], work[top + RIGHT + 1, lane] + taken[4]
    p0, p1 = p0 + taken[5], p1 + taken[6]
    work[top + A00, lane], work[top + A01, lane], work[top + A11, lane] = i00, i01, i11
    work[top + RIGHT, lane], work[top + RIGHT + 1, lane] = r0, r1
    work[top + P0, lane], work[top + P1, lane] = p0, p1
    work[top + Z0, lane], work[top + Z1, lane] = q0, q1
    x0, x1 = i00 * r0 + i01 * r1, i01 * r0 + i11 * r1
    f0, f1 = i00 * p0 + i01 * p1, i01 * p0 + i11 * p1
    h0, h1 = i00 * q0 + i01 * q1, i01 * q0 + i11 * q1
    handed = (
        link0 * link0 * i00,
        link0 * link1 * i01,
        link1 * link1 * i11,
        link0 * x0,
        link1 * x1,
        link0 * f0,
        link1 * f1,
        link0 * h0,
        link1 * h1,
    )
    return handed, (
        p0 * x0 + p1 * x1,
        q0 * x0 + q1 * x1,
        p0 * f0 + p1 * f1,
        p0 * h0 + p1 * h1,
        q0 * h0 + q1 * h1,
    )


@njit(**PLAIN, **_inline)
def substitute(n_s, d, t, work):
    """The fields, from the middle to both ends."""
    middle = n_s // 2
    left0, left1 = _field(middle, d, t, 0.0, 0.0, work)
    right0, right1 = left0, left1
    for i in range(1, middle + 1):
        s = middle - i
        top, lane = (s // LANES) * TOTAL, s % LANES
        left0, left1 = _field(s, d, t, work[top + LINK, lane] * left0, work[top + LINK + 1, lane] * left1, work)
        s = middle + i
        if s < n_s:
            top, lane = ((s - 1) // LANES) * TOTAL, (s - 1) % LANES
            right0, right1 = _field(s, d, t, work[top + LINK, lane] * right0, work[top + LINK + 1, lane] * right1, work)


@njit(**PLAIN, **_inline)
def _field(s, d, t, pull0, pull1, work):
    top, lane = (s // LANES) * TOTAL, s % LANES
    r0 = work[top + RIGHT, lane] - d * work[top + P0, lane] - t * work[top + Z0, lane] + pull0
    r1 = work[top + RIGHT + 1, lane] - d * work[top + P1, lane] - t * work[top + Z1, lane] + pull1
    b = work[top + A01, lane]
    v0, v1 = work[top + A00, lane] * r0 + b * r1, b * r0 + work[top + A11, lane] * r1
    work[top + FIELD, lane], work[top + FIELD + 1, lane] = v0, v1
    return v0, v1
