"""Line loads, fields and body displacements of a coupled mesh law in one Newton iteration, compiled.

The equations stand in `fem.contact.face`; here the slices need not be solved before the fields move. With the slices'
matrices J and residuals r = x_eff - C f - A f (B - ln f) - ..., the fields answer to the loads f + J^-1 r, and then

    f <- f + J^-1 (r - g dv - dd - dt y).

A pair leaves a slice when its load falls below zero and returns where its approach is positive. Slices of at most two
pairs; `False` is returned, and `fem.contact.face` solves in safer steps, when anything else turns up.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from fem.contact import lanes
from fem.contact.packing import BODY, LANES, LENGTH, ROWS_PER_BLOCK, SLICE_ROWS, SLOPE, Y

STEPS = 14
CLOSE = 1e-5  # largest relative step of a line load that leaves an error of a tenth of its square
_inline: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "forceinline": True,
    "fastmath": {"contract"},
}
_LN2 = 0.6931471805599453


@njit(**_inline)
def start(tables, block, face_width, gain, rows, bits):
    """First line loads, as if all slices were loaded alike."""
    slope = tables[SLOPE]
    for a in range(2):
        at = a * lanes.SECOND
        for s in range(LANES):
            x = rows[at + lanes.X, s]
            here = min(block * LANES + s, gain.shape[0] - 1)
            soft = rows[at + lanes.COMPLIANCE, s] + gain[here, a] * gain[here, a] + 1.5 * tables[BODY] * face_width
            rows[at + lanes.ON, s] = 1.0 if x > 0.0 else 0.0
            rows[at + lanes.LOAD, s] = x / soft if x > 0.0 else 1.0
            rough = (bits[at + lanes.LOAD, s] * 2.0**-52 - 1022.957) * _LN2
            depth = max(1.0, rows[at + lanes.DEPTH, s] - rough)
            rows[at + lanes.LOAD, s] = x / (soft + slope * depth) if x > 0.0 else 1.0


@njit(**_inline)
def linearise(tables, block, gain, line, rows, bits, count, slot, load, stiffness, lines_of, gains_of):
    """Slots that carry: phi (f + J^-1 r) and phi J^-1; False where a load is beyond the range of the Hertz term."""
    slope = tables[SLOPE]
    lanes.logarithm(0, rows, bits)
    lanes.logarithm(lanes.SECOND, rows, bits)
    for s in range(min(LANES, count.size - block * LANES)):
        at = block * LANES + s
        on0, on1 = rows[lanes.ON, s] > 0.0, rows[lanes.SECOND + lanes.ON, s] > 0.0
        count[at] = 0
        if not (on0 or on1):
            continue
        phi0, phi1 = rows[lanes.FRACTION, s], rows[lanes.SECOND + lanes.FRACTION, s]
        f0 = rows[lanes.LOAD, s] if on0 else 0.0
        f1 = rows[lanes.SECOND + lanes.LOAD, s] if on1 else 0.0
        depth0 = rows[lanes.DEPTH, s] - rows[lanes.LOG, s]
        depth1 = rows[lanes.SECOND + lanes.DEPTH, s] - rows[lanes.SECOND + lanes.LOG, s]
        if slope > 0.0 and ((on0 and depth0 < 1.0) or (on1 and depth1 < 1.0)):
            return False
        c0, c1 = rows[lanes.COMPLIANCE, s], rows[lanes.SECOND + lanes.COMPLIANCE, s]
        d0, d1 = c0 + slope * (depth0 - 1.0), c1 + slope * (depth1 - 1.0)
        u, v = rows[lanes.COUPLING, s] * phi1, rows[lanes.COUPLING, s] * phi0
        r0 = rows[lanes.X, s] - f0 * (c0 + slope * depth0) - u * f1
        r1 = rows[lanes.SECOND + lanes.X, s] - f1 * (c1 + slope * depth1) - v * f0
        if on0 and on1:
            scale = 1.0 / (d0 * d1 - u * v)
            j00, j01, j10, j11 = d1 * scale, -u * scale, -v * scale, d0 * scale
            load[at, 0], load[at, 1] = phi0 * (f0 + j00 * r0 + j01 * r1), phi1 * (f1 + j10 * r0 + j11 * r1)
            stiffness[at, 0, 0], stiffness[at, 0, 1] = phi0 * j00, phi0 * j01
            stiffness[at, 1, 0], stiffness[at, 1, 1] = phi1 * j10, phi1 * j11
            lines_of[at, 0], lines_of[at, 1] = line[at, 0], line[at, 1]
            gains_of[at, 0], gains_of[at, 1] = gain[at, 0], gain[at, 1]
            slot[at, 0], slot[at, 1] = 0, 1
            count[at] = 2
        else:
            a = 0 if on0 else 1
            phi, d, f, r = (phi0, d0, f0, r0) if on0 else (phi1, d1, f1, r1)
            load[at, 0], stiffness[at, 0, 0] = phi * (f + r / d), phi / d
            lines_of[at, 0], gains_of[at, 0], slot[at, 0] = line[at, a], gain[at, a], a
            count[at] = 1
    return True


@njit(**_inline)
def advance(tables, block, gain, line, rows, count, slot, load, stiffness, gains_of, lines_of, change, dd, dt):
    """Move loads and approaches by the step of the fields; largest relative step, 1 where a pair came or went."""
    base = SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    spread = tables[LENGTH] > 0.0
    largest = 0.0
    for s in range(min(LANES, count.size - block * LANES)):
        at = block * LANES + s
        move = dd + dt * tables[base + Y * LANES + s]
        for a in range(count[at]):
            row = slot[at, a] * lanes.SECOND
            f, phi = rows[row + lanes.LOAD, s], rows[row + lanes.FRACTION, s]
            new = load[at, a]
            for b in range(count[at]):
                shift = move
                if spread:
                    shift += gains_of[at, b] * change[at, 0, lines_of[at, b]]
                new -= stiffness[at, a, b] * shift
            new /= phi
            if new <= 0.0:
                rows[row + lanes.ON, s] = 0.0
                new, largest = 1.0, 1.0
            else:
                largest = max(largest, abs(new - f) / f)
            rows[row + lanes.LOAD, s] = new
        for a in range(2):
            row = a * lanes.SECOND
            if rows[row + lanes.X, s] > lanes.NEVER:
                rows[row + lanes.X, s] -= move
                if spread:
                    rows[row + lanes.X, s] -= gain[at, a] * change[at, 0, line[at, a]]
        for a in range(2):
            row, other = a * lanes.SECOND, (1 - a) * lanes.SECOND
            if rows[row + lanes.ON, s] == 0.0 and rows[row + lanes.X, s] > lanes.NEVER:
                x = rows[row + lanes.X, s]
                if rows[other + lanes.ON, s] > 0.0:
                    x -= rows[lanes.COUPLING, s] * rows[other + lanes.FRACTION, s] * rows[other + lanes.LOAD, s]
                if x > 1e-15 * abs(rows[row + lanes.X, s]) and x > 1e-18:
                    soft = rows[row + lanes.COMPLIANCE, s] + 0.8 * tables[SLOPE] * rows[row + lanes.DEPTH, s]
                    rows[row + lanes.ON, s], rows[row + lanes.LOAD, s] = 1.0, x / soft
                    largest = 1.0
    return largest


@njit(**_inline)
def finish(tables, block, n_s, count, slot, load, rows, bits, energy, rate):
    """Add the block's strain energy and its slope, and set the loads phi f of the solution."""
    lanes.logarithm(0, rows, bits)
    lanes.logarithm(lanes.SECOND, rows, bits)
    for s in range(LANES):
        rows[lanes.RARE, s] = 0.0
        on0, on1 = rows[lanes.ON, s], rows[lanes.SECOND + lanes.ON, s]
        rows[lanes.LOAD, s], rows[lanes.SECOND + lanes.LOAD, s] = (
            rows[lanes.LOAD, s] * on0,
            rows[lanes.SECOND + lanes.LOAD, s] * on1,
        )
        rows[lanes.UPPER, s] = rows[lanes.LOWER, s] = 0.0
    _, _, stored, _, _, _, along = lanes.block_sums(tables, block, rows)
    for s in range(min(LANES, n_s - block * LANES)):
        at = block * LANES + s
        for a in range(count[at]):
            row = slot[at, a] * lanes.SECOND
            load[at, a] = rows[row + lanes.FRACTION, s] * rows[row + lanes.LOAD, s]
    return energy + stored, rate + along
