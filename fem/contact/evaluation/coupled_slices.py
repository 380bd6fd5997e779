"""Coupled mesh laws slice by slice, compiled: any number of pairs in a slice, neighbours that pull too, any load.

The equations stand in `fem.contact.evaluation.coupled_face`. The slices are solved exactly at fixed fields and body
displacements, then those move by a Newton step with the stiffnesses of the slices, in turn: slow and safe.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit, types

from fem.contact.evaluation import general_slices, paired_slices
from fem.contact.evaluation.field_elimination import in_series
from fem.contact.evaluation.packing import (
    CELL,
    GRID,
    LANES,
    LARGEST_NEAR,
    LENGTH,
    MAX_PAIRS,
    NEXT,
    PER_STEP,
    POSITIONS,
    REACH,
    ROWS_PER_BLOCK,
    SHIFT,
    SLICE_ROWS,
    SLICES,
    SLOPE,
    SPRING,
    START,
    WIDTH,
    Y,
)
from fem.numerics.compiled import FLOAT, INTEGER, MATRIX, PLAIN, VECTOR, apart, stored

STEPS = 40
CLOSE = 1e-11  # field step, relative to the largest, at which the loads found before it are taken
_inline: dict[str, Any] = {"forceinline": True, "fastmath": {"contract"}}


@njit(**PLAIN, **_inline)
def amplitude(tables, s, own_cycle, number):
    """g = sqrt(D) of pair `number` in slice s and its slope along xi."""
    base = SLICE_ROWS + (s // LANES) * ROWS_PER_BLOCK * LANES + s % LANES
    place = (own_cycle + tables[base + SHIFT * LANES] - number - tables[START]) * tables[PER_STEP]
    cell = min(max(int(place), 0), int(tables[POSITIONS]) - 2)
    k = int(tables[GRID]) + cell * int(tables[CELL]) + NEXT + 2 * int(tables[REACH])
    return tables[k] + (place - cell) * tables[k + 1], tables[k + 1] * tables[PER_STEP]


@njit(**PLAIN)
def assemble(tables, lines, count, line, gain, load, stiffness, v, inverse, right, own):
    """Blocks w + springs + w g K g, right-hand sides (residual, w g K 1, w g K y); own: F, M, k, k y, k y^2."""
    n_s = count.size
    for i in range(5):
        own[i] = 0.0
    for s in range(n_s):
        base = SLICE_ROWS + (s // LANES) * ROWS_PER_BLOCK * LANES + s % LANES
        y, w = tables[base + Y * LANES], tables[base + WIDTH * LANES]
        block, rest = inverse[s], right[s]
        behind, ahead = spring(tables, s - 1), spring(tables, s)
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


@njit(**PLAIN)
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


@njit(**PLAIN, **_inline)
def spring(tables, s):
    """Spring a^2 / distance between slice s and the next; 0 before the first and behind the last."""
    return tables[SLICE_ROWS + ((s // LANES) * ROWS_PER_BLOCK + SPRING) * LANES + s % LANES] if s >= 0 else 0.0


@njit(**PLAIN)
def invert(n, matrix):
    """Inverse of a small symmetric positive definite matrix, in place (Gauss-Jordan without pivoting)."""
    if n == 2:
        a, b, c = matrix[0, 0], matrix[0, 1], matrix[1, 1]
        scale = 1.0 / (a * c - b * b)
        matrix[0, 0], matrix[1, 1] = c * scale, a * scale
        matrix[0, 1] = matrix[1, 0] = -b * scale
        return
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


@njit(**PLAIN)
def body_step(tables, own, taken, d, t, out):
    """Changes of d and t, then the total stiffnesses k, k y, k y^2 with fields and bodies in series."""
    k00, k01, k11 = own[2] - taken[2], own[3] - taken[3], own[4] - taken[4]
    force, moment = own[0] - taken[0] + k00 * d + k01 * t, own[1] - taken[1] + k01 * d + k11 * t
    new_d, new_t, out[2], out[3], out[4] = in_series(tables, k00, k01, k11, force, moment)
    out[0], out[1] = new_d - d, new_t - t


@njit(**PLAIN)
def solve_in_turn(
    tables, own_cycle, delta, psi, near, n_near, first, lines, count, line, gain, load, stiffness, v, inverse, right,
    scratch, own, taken, out,
):  # fmt: skip
    """Slices solved at fixed fields, then the fields, in turn: for any number of pairs; U, dU/dc', d, t."""
    slope = tables[SLOPE]
    n_s = count.size
    one, relief = np.empty((general_slices.TOTAL, MAX_PAIRS)), np.zeros(LARGEST_NEAR)
    matrix = np.empty((MAX_PAIRS, MAX_PAIRS))
    energy = rate = d = t = scale = 0.0
    for step in range(STEPS):
        energy = rate = 0.0
        for s in range(n_s):
            for m in range(n_near if lines > 0 else 0):
                g, _ = amplitude(tables, s, own_cycle, near[m, 0])
                row = int(near[m, 0]) - first
                relief[m] = g * v[s, row] if 0 <= row < lines else 0.0
            block, lane = s // LANES, s % LANES
            n, _, _, u, r = general_slices.solve_slice(
                tables, block, lane, own_cycle, delta - d, psi - t, near, n_near, relief, one
            )
            w = tables[SLICE_ROWS + (block * ROWS_PER_BLOCK + WIDTH) * LANES + lane]
            energy, rate = energy + w * u, rate + w * r
            count[s] = n
            general_slices.slice_stiffness(n, slope, one, matrix)
            for a in range(count[s]):
                line[s, a] = int(one[paired_slices.PAIR, a]) - first
                load[s, a] = one[paired_slices.FRACTION, a] * one[paired_slices.LOAD, a]
                if lines > 0:
                    gain[s, a], _ = amplitude(tables, s, own_cycle, one[paired_slices.PAIR, a])
                for b in range(count[s]):
                    stiffness[s, a, b] = matrix[a, b]
        assemble(tables, lines, count, line, gain, load, stiffness, v, inverse, right, own)
        if lines > 0:
            field_step(tables, lines, inverse, right, taken, scratch)
        body_step(tables, own, taken, d, t, out)
        largest = abs(out[0]) + abs(out[1]) * abs(tables[SLICE_ROWS + Y * LANES])
        for s in range(n_s):
            for p in range(lines):
                right[s, 0, p] -= right[s, 1, p] * out[0] + right[s, 2, p] * out[1]
            for a in range(count[s] if lines > 0 else 0):
                largest = max(largest, abs(gain[s, a] * right[s, 0, line[s, a]]))
        scale = max(scale, largest)
        part = 1.0 if step < 8 or largest <= 1e-3 * scale else 0.5
        v += part * right[:, 0]
        d, t = d + part * out[0], t + part * out[1]
        if largest <= CLOSE * scale:
            break
    return energy, rate, d, t


@apart(types.UniTuple(FLOAT, 7), VECTOR, FLOAT, FLOAT, FLOAT, MATRIX, INTEGER, VECTOR)
@stored(__file__)
def evaluate_in_turn(tables, own_cycle, delta, psi, near, n_near, pair_force):
    """F, M, U, dF/d delta, dF/d psi, dM/d psi, dU/dc' at one state; pair_force as in `coupled_face`."""
    n_s = int(tables[SLICES])
    first = int(near[0, 0])
    lines = int(near[n_near - 1, 0]) - first + 1 if tables[LENGTH] > 0.0 else 0
    count, line = np.zeros(n_s, np.int64), np.zeros((n_s, MAX_PAIRS), np.int64)
    gain, load = np.zeros((n_s, MAX_PAIRS)), np.empty((n_s, MAX_PAIRS))
    stiffness = np.empty((n_s, MAX_PAIRS, MAX_PAIRS))
    v, inverse, right = np.zeros((n_s, lines)), np.empty((n_s, lines, lines)), np.empty((n_s, 3, lines))
    scratch, own, taken, out = np.empty((n_s, 3, lines)), np.empty(5), np.zeros(5), np.empty(5)
    energy, rate, d, t = solve_in_turn(
        tables, own_cycle, delta, psi, near, n_near, first, lines, count, line, gain, load, stiffness, v, inverse,
        right, scratch, own, taken, out,
    )  # fmt: skip
    force = moment = 0.0
    for s in range(n_s):
        base = SLICE_ROWS + (s // LANES) * ROWS_PER_BLOCK * LANES + s % LANES
        w, y = tables[base + WIDTH * LANES], tables[base + Y * LANES]
        for a in range(count[s]):
            force, moment = force + w * load[s, a], moment + w * load[s, a] * y
            if lines > 0:
                g, g_slope = amplitude(tables, s, own_cycle, float(first + line[s, a]))
                energy += 0.5 * w * g * load[s, a] * v[s, line[s, a]]
                rate -= w * g_slope * load[s, a] * v[s, line[s, a]]
            place = first + line[s, a] - math.floor(own_cycle) + pair_force.size // 2
            if 0 <= place < pair_force.size:
                pair_force[place] += w * load[s, a]
    energy += 0.5 * (d * force + t * moment)
    return force, moment, energy, out[2], out[3], out[4], rate
