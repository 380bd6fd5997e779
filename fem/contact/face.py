"""Mesh laws whose slices are coupled along the face, compiled: tooth bending that spreads, wind-up and tilt of the bodies.

With the slice potentials U_s, convex in the approach of each pair, the law of `fem.contact.law` is the minimum of

    sum_s w_s U_s(x_s - g v_s - d - t y_s) + v' T v / 2 + d^2 / (2 E_0) + t^2 / (2 E_1),   g = sqrt(D)

over the fields v_p (one per pair) and the body displacements d, t; T stands for 1 - a^2 d^2/dy^2 between the slices
(diagonal w_s, springs a^2 / distance between neighbours, nothing beyond the ends). All parts are convex, so the minimum
is unique and U stays convex in (delta, psi). Newton: the slices are solved at the present fields, their stiffnesses
K_s = phi J^-1 enter

    (T + w g K g) dv = w g phi f - T v - w g K 1 (dd + dt y)

which is tridiagonal in blocks of the pairs; d and t, coupled with everything, are two right-hand sides more. F, M, U and
all derivatives are those of the minimum (envelope theorem); the total stiffness is the slices' with fields and bodies
in series.

Hertz contacts bend little, so three or four steps reach round-off; a step is halved where it fails to reduce the
gradient after the first few.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from fem.contact import lanes, slices
from fem.contact.near import pairs_near
from fem.contact.packing import (
    BLOCKS,
    BODY,
    CELL,
    GRID,
    LANES,
    LARGEST_NEAR,
    LENGTH,
    NEXT,
    OFFSET,
    PER_STEP,
    POSITIONS,
    REACH,
    ROWS_PER_BLOCK,
    SHIFT,
    SIGN,
    SLICE_ROWS,
    SLICES,
    SLOPE,
    START,
    TILT,
    WIDTH,
    Y,
)

SLOTS = 4  # pairs that one slice loads at most where slices are coupled
STEPS = 40
CLOSE = 1e-7  # field step, relative to the largest approach, that leaves an error of its square
_options: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy"}
_inline: dict[str, Any] = {**_options, "forceinline": True, "fastmath": {"contract"}}


@njit(**_inline)
def amplitude(tables, s, own_cycle, number):
    """g = sqrt(D) of pair `number` in slice s and its slope along xi."""
    base = SLICE_ROWS + (s // LANES) * ROWS_PER_BLOCK * LANES + s % LANES
    place = (own_cycle + tables[base + SHIFT * LANES] - number - tables[START]) * tables[PER_STEP]
    cell = min(max(int(place), 0), int(tables[POSITIONS]) - 2)
    k = int(tables[GRID]) + cell * int(tables[CELL]) + NEXT + 2 * int(tables[REACH])
    return tables[k] + (place - cell) * tables[k + 1], tables[k + 1] * tables[PER_STEP]


@njit(**_inline)
def read_lanes(block, tables, work, count, line, load, stiffness, first):
    """Slots of the usual slices of a solved block: which line (pair), phi f, and phi J^-1."""
    slope = tables[SLOPE]
    for s in range(min(LANES, count.size - block * LANES)):
        at = block * LANES + s
        if work[lanes.RARE, s] > 0.0:
            continue
        on0, on1 = work[lanes.ON, s], work[lanes.SECOND + lanes.ON, s]
        phi0, phi1 = work[lanes.FRACTION, s], work[lanes.SECOND + lanes.FRACTION, s]
        d0 = work[lanes.COMPLIANCE, s] + slope * max(work[lanes.DEPTH, s] - work[lanes.LOG, s] - 1.0, 0.0)
        d1 = work[lanes.SECOND + lanes.COMPLIANCE, s]
        d1 += slope * max(work[lanes.SECOND + lanes.DEPTH, s] - work[lanes.SECOND + lanes.LOG, s] - 1.0, 0.0)
        n = 0
        if on0 > 0.0:
            line[at, n], load[at, n] = int(work[lanes.PAIR, s]) - first, phi0 * work[lanes.LOAD, s]
            stiffness[at, 0, 0] = phi0 / d0
            n += 1
        if on1 > 0.0:
            line[at, n] = int(work[lanes.SECOND + lanes.PAIR, s]) - first
            load[at, n], stiffness[at, n, n] = phi1 * work[lanes.SECOND + lanes.LOAD, s], phi1 / d1
            n += 1
        if n == 2:
            u, v = work[lanes.UPPER, s], work[lanes.LOWER, s]
            scale = 1.0 / (d0 * d1 - u * v)
            stiffness[at, 0, 0], stiffness[at, 0, 1] = phi0 * d1 * scale, -phi0 * u * scale
            stiffness[at, 1, 0], stiffness[at, 1, 1] = -phi1 * v * scale, phi1 * d0 * scale
        count[at] = n


@njit(**_options)
def assemble(tables, lines, count, line, gain, load, stiffness, v, inverse, right, own):
    """Blocks w + springs + w g K g, right-hand sides (residual, w g K 1, w g K y); own: F, M, k, k y, k y^2."""
    n_s = count.size
    for i in range(5):
        own[i] = 0.0
    for s in range(n_s):
        base = SLICE_ROWS + (s // LANES) * ROWS_PER_BLOCK * LANES + s % LANES
        y, w = tables[base + Y * LANES], tables[base + WIDTH * LANES]
        block, rest = inverse[s], right[s]
        behind, ahead = spring(tables, s - 1), spring(tables, s) if s < n_s - 1 else 0.0
        for p in range(lines):
            for q in range(lines):
                block[p, q] = 0.0
            block[p, p] = w + behind + ahead
            rest[0, p] = -(w + behind + ahead) * v[s, p]
            if s > 0:
                rest[0, p] += behind * v[s - 1, p]
            if s < n_s - 1:
                rest[0, p] += ahead * v[s + 1, p]
            rest[1, p] = rest[2, p] = 0.0
        for a in range(count[s]):
            p, row = line[s, a], 0.0
            for b in range(count[s]):
                row += stiffness[s, a, b]
                if lines > 0:
                    block[p, line[s, b]] += w * gain[s, a] * stiffness[s, a, b] * gain[s, b]
            if lines > 0:
                rest[0, p] += w * gain[s, a] * load[s, a]
                rest[1, p] = w * gain[s, a] * row
                rest[2, p] = w * gain[s, a] * row * y
            own[0] += w * load[s, a]
            own[1] += w * load[s, a] * y
            own[2] += w * row
            own[3] += w * row * y
            own[4] += w * row * y * y


@njit(**_options)
def field_step(tables, lines, inverse, right, taken, work):
    """Solve the block-tridiagonal system; the three solutions stand in `right`.

    taken: what the fields take from F, M by the first solution, then from k, k y, k y^2.
    """
    n_s = right.shape[0]
    for s in range(n_s):
        for p in range(lines):
            work[s, 0, p], work[s, 1, p] = right[s, 1, p], right[s, 2, p]
        if s > 0:
            q = spring(tables, s - 1)
            for a in range(lines):
                for b in range(lines):
                    factor = q * inverse[s - 1, a, b]
                    inverse[s, a, b] -= q * factor
                    for r in range(3):
                        right[s, r, a] += factor * right[s - 1, r, b]
        invert(lines, inverse[s])
    for i in range(5):
        taken[i] = 0.0
    for s in range(n_s - 1, -1, -1):
        if s < n_s - 1:
            q = spring(tables, s)
            for p in range(lines):
                for r in range(3):
                    right[s, r, p] += q * right[s + 1, r, p]
        for r in range(3):
            for p in range(lines):
                total = 0.0
                for q in range(lines):
                    total += inverse[s, p, q] * right[s, r, q]
                work[s, 2, p] = total
            for p in range(lines):
                right[s, r, p] = work[s, 2, p]
        for p in range(lines):
            taken[0] += work[s, 0, p] * right[s, 0, p]
            taken[1] += work[s, 1, p] * right[s, 0, p]
            taken[2] += work[s, 0, p] * right[s, 1, p]
            taken[3] += work[s, 0, p] * right[s, 2, p]
            taken[4] += work[s, 1, p] * right[s, 2, p]


@njit(**_inline)
def spring(tables, s):
    """Spring a^2 / distance between slice s and the next; 0 before the first."""
    if s < 0:
        return 0.0
    here = SLICE_ROWS + (s // LANES) * ROWS_PER_BLOCK * LANES + s % LANES
    there = SLICE_ROWS + ((s + 1) // LANES) * ROWS_PER_BLOCK * LANES + (s + 1) % LANES
    return tables[LENGTH] * tables[LENGTH] / (tables[there + Y * LANES] - tables[here + Y * LANES])


@njit(**_options)
def invert(n, matrix):
    """Inverse of a small symmetric positive definite matrix, in place (Gauss-Jordan without pivoting)."""
    for k in range(n):
        pivot = 1.0 / matrix[k, k]
        matrix[k, k] = 1.0
        for j in range(n):
            matrix[k, j] *= pivot
        for i in range(n):
            if i != k:
                factor = matrix[i, k]
                if factor != 0.0:
                    matrix[i, k] = 0.0
                    for j in range(n):
                        matrix[i, j] -= factor * matrix[k, j]


@njit(**_options)
def evaluate_coupled(tables, cycle, delta, psi, pinion, wheel, pair_force):
    """What `fem.contact.kernel.evaluate_flank` returns, for a law with coupling along the face."""
    own_cycle = tables[SIGN] * cycle + tables[OFFSET]
    blocks, n_s = int(tables[BLOCKS]), int(tables[SLICES])
    work = np.empty((blocks * lanes.TOTAL, LANES))
    bits = work.view(np.int64)
    near = np.empty((LARGEST_NEAR, 8))
    n_near = pairs_near(tables, own_cycle, pinion, wheel, near)
    slope, first = tables[SLOPE], int(near[0, 0])
    touched = False
    for k in range(blocks):
        rows = work[k * lanes.TOTAL : (k + 1) * lanes.TOTAL]
        found = lanes.gather(tables, k, own_cycle, (delta, psi, delta, psi), near, n_near, rows)
        touched = touched or found
    if n_near == 0 or not touched:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    lines = int(near[n_near - 1, 0]) - first + 1 if tables[LENGTH] > 0.0 else 0
    free = np.empty((blocks, 2, LANES))
    early = np.empty((blocks, LANES))
    for k in range(blocks):
        for s in range(LANES):
            free[k, 0, s] = work[k * lanes.TOTAL + lanes.X, s]
            free[k, 1, s] = work[k * lanes.TOTAL + lanes.SECOND + lanes.X, s]
            early[k, s] = work[k * lanes.TOTAL + lanes.RARE, s]
    count, line = np.zeros(n_s, np.int64), np.zeros((n_s, SLOTS), np.int64)
    gain, load, stiffness = np.zeros((n_s, SLOTS)), np.zeros((n_s, SLOTS)), np.zeros((n_s, SLOTS, SLOTS))
    v, inverse, right = np.zeros((n_s, lines)), np.empty((n_s, lines, lines)), np.empty((n_s, 3, lines))
    scratch, own, taken = np.empty((n_s, 3, lines)), np.empty(5), np.zeros(5)
    one, relief = np.empty((slices.TOTAL, slices.MAX_PAIRS)), np.zeros(LARGEST_NEAR)
    d = t = energy = rate = 0.0
    k00 = k01 = k11 = 0.0
    scale = 0.0
    for step in range(STEPS):
        energy = rate = 0.0
        for k in range(blocks):
            rows, row_bits = (
                work[k * lanes.TOTAL : (k + 1) * lanes.TOTAL],
                bits[k * lanes.TOTAL : (k + 1) * lanes.TOTAL],
            )
            relieve(tables, k, own_cycle, d, t, first, lines, free, early, v, rows)
            lanes.guess(slope, rows, row_bits)
            for _ in range(lanes.SWEEPS):
                if lanes.sweep(slope, rows, row_bits) <= lanes.CLOSE * lanes.CLOSE:
                    break
            rare = lanes.switch_off(slope, rows)
            _, _, u, _, _, _, r = lanes.block_sums(tables, k, rows)
            energy, rate = energy + u, rate + r
            read_lanes(k, tables, rows, count, line, load, stiffness, first)
            if rare > 0.0:
                for s in range(LANES):
                    if rows[lanes.RARE, s] > 0.0 and k * LANES + s < n_s:
                        at = k * LANES + s
                        for m in range(n_near if lines > 0 else 0):
                            g, _ = amplitude(tables, at, own_cycle, near[m, 0])
                            relief[m] = g * v[at, int(near[m, 0]) - first]
                        n, _, _, u, r = slices.solve_slice(
                            tables, k, s, own_cycle, delta - d, psi - t, near, n_near, relief, one
                        )
                        w = tables[SLICE_ROWS + (k * ROWS_PER_BLOCK + WIDTH) * LANES + s]
                        energy, rate = energy + w * u, rate + w * r
                        count[at] = min(n, SLOTS)
                        slices.slice_stiffness(n, slope, one, stiffness[at])
                        for a in range(count[at]):
                            line[at, a] = int(one[lanes.PAIR, a]) - first
                            load[at, a] = one[lanes.FRACTION, a] * one[lanes.LOAD, a]
        for s in range(n_s):
            for a in range(count[s] if lines > 0 else 0):
                g, g_slope = amplitude(tables, s, own_cycle, first + line[s, a])
                gain[s, a] = g
        assemble(tables, lines, count, line, gain, load, stiffness, v, inverse, right, own)
        if lines > 0:
            field_step(tables, lines, inverse, right, taken, scratch)
        k00, k01, k11 = own[2] - taken[2], own[3] - taken[3], own[4] - taken[4]
        e0, e1 = tables[BODY], tables[TILT]
        r0, r1 = e0 * (own[0] - taken[0]) - d, e1 * (own[1] - taken[1]) - t
        a00, a01, a10, a11 = 1.0 + e0 * k00, e0 * k01, e1 * k01, 1.0 + e1 * k11
        det = a00 * a11 - a01 * a10
        dd, dt = (a11 * r0 - a01 * r1) / det, (a00 * r1 - a10 * r0) / det
        part = 1.0 if step < 8 else 0.5
        largest = abs(dd) + abs(dt) * abs(tables[SLICE_ROWS + Y * LANES])
        for s in range(n_s):
            for p in range(lines):
                change = right[s, 0, p] - right[s, 1, p] * dd - right[s, 2, p] * dt
                v[s, p] += part * change
                right[s, 0, p] = change
            for a in range(count[s] if lines > 0 else 0):
                largest = max(largest, abs(gain[s, a] * right[s, 0, line[s, a]]))
        d, t = d + part * dd, t + part * dt
        scale = max(scale, largest)
        if largest <= CLOSE * scale:
            break
    force, moment = own[0], own[1]
    energy += 0.5 * (d * force + t * moment)
    for s in range(n_s):
        base = SLICE_ROWS + (s // LANES) * ROWS_PER_BLOCK * LANES + s % LANES
        w = tables[base + WIDTH * LANES]
        for a in range(count[s]):
            if lines > 0:
                g, g_slope = amplitude(tables, s, own_cycle, first + line[s, a])
                energy += 0.5 * w * g * load[s, a] * v[s, line[s, a]]
                rate -= w * g_slope * load[s, a] * v[s, line[s, a]]
            place = first + line[s, a] - math.floor(own_cycle) + pair_force.size // 2
            if 0 <= place < pair_force.size:
                pair_force[place] += w * load[s, a]
    h00, h01 = (k00 * a11 - k01 * a10) / det, (k01 * a00 - k00 * a01) / det
    h11 = (k11 * a00 - k01 * a01) / det
    return force, moment, energy, h00, h01, h11, tables[SIGN] * rate


@njit(**_inline)
def relieve(tables, k, own_cycle, d, t, first, lines, free, early, v, rows):
    """Approaches X of a block at the present fields and body displacements."""
    base = SLICE_ROWS + k * ROWS_PER_BLOCK * LANES
    n_s = int(tables[SLICES])
    for s in range(LANES):
        y = tables[base + Y * LANES + s]
        rows[lanes.RARE, s] = early[k, s]
        for a in range(2):
            x = free[k, a, s]
            if x > lanes.NEVER:
                x -= d + t * y
                if lines > 0:
                    number = rows[a * lanes.SECOND + lanes.PAIR, s]
                    at = min(k * LANES + s, n_s - 1)
                    g, _ = amplitude(tables, at, own_cycle, number)
                    x -= g * v[at, int(number) - first]
            rows[a * lanes.SECOND + lanes.X, s] = x
