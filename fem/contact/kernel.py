"""Compiled door to the mesh law: one state in, forces, energy and their derivatives out.

`tables` is the array of `fem.contact.packing.pack`, `pinion` and `wheel` the tooth terms of `fem.contact.teeth`. The
mathematics stands in `fem.contact.evaluate`; sixteen usual slices at a time are solved in `fem.contact.lanes`, the
others one by one in `fem.contact.slices`.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

from fem.contact import lanes, slices
from fem.contact.face import evaluate_coupled
from fem.contact.near import pairs_near
from fem.contact.packing import (
    BLOCKS,
    COUPLED,
    LANES,
    LARGEST_NEAR,
    OFFSET,
    ROWS_PER_BLOCK,
    SIGN,
    SLICE_ROWS,
    SLOPE,
    WIDTH,
    Y,
)

_options: dict[str, Any] = {"nogil": True, "error_model": "numpy"}


@njit(**_options, forceinline=True)
def settle(slope, work, bits):
    """Newton sweeps of a block until they settle; returns the number of rare slices."""
    for _ in range(lanes.SWEEPS):
        if lanes.sweep(slope, work, bits) <= lanes.CLOSE * lanes.CLOSE:
            break
    return lanes.switch_off(slope, work)


@njit(**_options)
def evaluate_flank(tables, cycle, delta, psi, pinion, wheel, pair_force):
    """Sum over the blocks; adds each pair's force to pair_force[p - floor(c') + size // 2] where that exists."""
    force = moment = energy = k = mixed = tilt = rate = 0.0
    if tables[COUPLED] > 0.0:
        r = evaluate_coupled(tables, cycle, (delta, psi, delta, psi), np.int64(1), pinion, wheel, pair_force)
        return r[0], r[1], r[2], r[3], r[4], r[5], r[6]
    own_cycle = tables[SIGN] * cycle + tables[OFFSET]
    work = np.empty((lanes.TOTAL + LARGEST_NEAR // 2, LANES))
    bits = work.view(np.int64)
    near = work[lanes.TOTAL :].reshape((LARGEST_NEAR, 8))
    n_near = pairs_near(tables, own_cycle, pinion, wheel, near)
    slope = tables[SLOPE]
    for block in range(int(tables[BLOCKS])):
        if not lanes.gather(tables, block, own_cycle, (delta, psi, delta, psi), near, n_near, work):
            continue
        lanes.guess(slope, work, bits)
        rare = settle(slope, work, bits)
        f, m, u, a, b, c, r = lanes.block_sums(tables, block, work)
        force, moment, energy, rate = force + f, moment + m, energy + u, rate + r
        k, mixed, tilt = k + a, mixed + b, tilt + c
        if pair_force.size > 0:
            add_shares(tables, block, math.floor(own_cycle), work, pair_force)
        if rare > 0.0:
            f, m, u, a, b, c, r = rare_sums(tables, block, own_cycle, delta, psi, near, n_near, work, pair_force)
            force, moment, energy, rate = force + f, moment + m, energy + u, rate + r
            k, mixed, tilt = k + a, mixed + b, tilt + c
    return force, moment, energy, k, mixed, tilt, tables[SIGN] * rate


@njit(**_options)
def evaluate_two_states(tables, cycle, delta, psi, delta_0, psi_0, pinion, wheel):
    """What `evaluate_two` returns.

    The tables are read once and the second Newton iteration starts from the line loads of the first.

    Returns
    -------
    F, M, U, dF/d delta, dF/d psi, dM/d psi of the first state, then the same of the second
    """
    states = (delta, psi, delta_0, psi_0)
    none = np.empty(0)
    if tables[COUPLED] > 0.0:
        r = evaluate_coupled(tables, cycle, states, np.int64(2), pinion, wheel, none)
        return r[0], r[1], r[2], r[3], r[4], r[5], r[7], r[8], r[9], r[10], r[11], r[12]
    own_cycle = tables[SIGN] * cycle + tables[OFFSET]
    work = np.empty((lanes.TOTAL + LARGEST_NEAR // 2, LANES))
    bits = work.view(np.int64)
    near = work[lanes.TOTAL :].reshape((LARGEST_NEAR, 8))
    n_near = pairs_near(tables, own_cycle, pinion, wheel, near)
    slope = tables[SLOPE]
    f0 = m0 = u0 = a0 = b0 = c0 = f1 = m1 = u1 = a1 = b1 = c1 = 0.0
    for block in range(int(tables[BLOCKS])):
        if not lanes.gather(tables, block, own_cycle, states, near, n_near, work):
            continue
        lanes.take_state(tables, block, states, -1, 0, work)
        lanes.guess(slope, work, bits)
        rare = settle(slope, work, bits)
        f, m, u, a, b, c, _ = lanes.block_sums(tables, block, work)
        f0, m0, u0, a0, b0, c0 = f0 + f, m0 + m, u0 + u, a0 + a, b0 + b, c0 + c
        if rare > 0.0:
            f, m, u, a, b, c, _ = rare_sums(tables, block, own_cycle, delta, psi, near, n_near, work, none)
            f0, m0, u0, a0, b0, c0 = f0 + f, m0 + m, u0 + u, a0 + a, b0 + b, c0 + c
        lanes.take_state(tables, block, states, 0, 1, work)
        rare = settle(slope, work, bits)
        f, m, u, a, b, c, _ = lanes.block_sums(tables, block, work)
        f1, m1, u1, a1, b1, c1 = f1 + f, m1 + m, u1 + u, a1 + a, b1 + b, c1 + c
        if rare > 0.0:
            f, m, u, a, b, c, _ = rare_sums(tables, block, own_cycle, delta_0, psi_0, near, n_near, work, none)
            f1, m1, u1, a1, b1, c1 = f1 + f, m1 + m, u1 + u, a1 + a, b1 + b, c1 + c
    return f0, m0, u0, a0, b0, c0, f1, m1, u1, a1, b1, c1


@njit(**_options)
def add_shares(tables, block, anchor, work, pair_force):
    """Forces of the pairs in the slices that are not rare."""
    base = SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    for s in range(LANES):
        for at in (0, lanes.SECOND):
            force = tables[base + WIDTH * LANES + s] * work[at + lanes.FRACTION, s] * work[at + lanes.LOAD, s]
            if force > 0.0 and work[lanes.RARE, s] == 0.0:
                place = int(work[at + lanes.PAIR, s]) - anchor + pair_force.size // 2
                if 0 <= place < pair_force.size:
                    pair_force[place] += force


@njit(**_options)
def rare_sums(tables, block, own_cycle, delta, psi, near, n_near, work, pair_force):
    """The sums of the slices that `lanes` left over, and their shares."""
    force = moment = energy = k = mixed = tilt = rate = 0.0
    base = SLICE_ROWS + block * ROWS_PER_BLOCK * LANES
    own, none = np.empty((slices.TOTAL, slices.MAX_PAIRS)), np.zeros(LARGEST_NEAR)
    for s in range(LANES):
        if work[lanes.RARE, s] == 0.0:
            continue
        y, w = tables[base + Y * LANES + s], tables[base + WIDTH * LANES + s]
        n, load, stiff, stored, along = slices.solve_slice(
            tables, block, s, own_cycle, delta, psi, near, n_near, none, own
        )
        force, moment, energy, rate = force + w * load, moment + w * load * y, energy + w * stored, rate + w * along
        k, mixed, tilt = k + w * stiff, mixed + w * stiff * y, tilt + w * stiff * y * y
        for p in range(n if pair_force.size > 0 else 0):
            place = int(own[lanes.PAIR, p]) - math.floor(own_cycle) + pair_force.size // 2
            if 0 <= place < pair_force.size:
                pair_force[place] += w * own[lanes.FRACTION, p] * own[lanes.LOAD, p]
    return force, moment, energy, k, mixed, tilt, rate


def _doors(digest: int) -> tuple[Callable, ...]:
    """What other modules call. Only these are kept on disk, under the digest of all sources that they are made of."""

    @njit(**_options, cache=True)
    def evaluate(tables, cycle, delta, psi, pinion, wheel):
        """Response of one flank at one state.

        Parameters
        ----------
        tables : (n,), from `law_tables`
        cycle : mesh cycle c of the gears (1); the law turns it into its own c'
        delta, psi : approach along the transverse line of action (m) and tilt (rad)
        pinion (z1, 6), wheel (z2, 6) : tooth terms, see `fem.contact.teeth`

        Returns
        -------
        F (N), M (N m), U (J), dF/d delta (N/m), dF/d psi = dM/d delta (N), dM/d psi (N m), dU/dc (J)
        """
        here = cycle if digest >= 0 else math.nan
        return evaluate_flank(tables, here, delta, psi, pinion, wheel, np.empty(0))

    @njit(**_options, cache=True)
    def evaluate_two(tables, cycle, delta, psi, delta_0, psi_0, pinion, wheel):
        """Responses at (delta, psi) and at (delta_0, psi_0), both at the same cycle, without dU/dc.

        The tables are read once and the second Newton iteration starts from the line loads of the first.

        Returns
        -------
        F, M, U, dF/d delta, dF/d psi, dM/d psi of the first state, then the same of the second
        """
        here = cycle if digest >= 0 else math.nan
        return evaluate_two_states(tables, here, delta, psi, delta_0, psi_0, pinion, wheel)

    @njit(**_options, cache=True)
    def evaluate_shares(tables, cycle, delta, psi, pinion, wheel, pair_force):
        """As `evaluate`, and add the force (N) of pair p to pair_force[p - floor(c') + pair_force.size // 2].

        c' = cycle_sign c + cycle_offset. Pairs outside the array are left out; 2 `share_reach` + 1 places hold all.
        """
        here = cycle if digest >= 0 else math.nan
        return evaluate_flank(tables, here, delta, psi, pinion, wheel, pair_force)

    @njit(**_options, cache=True)
    def evaluate_many(tables, cycle, delta, psi, pinion, wheel, out):
        """Rows of `evaluate` for states given as arrays (n,), into out (n, 7)."""
        none = np.empty(0)
        for i in range(cycle.size if digest >= 0 else 0):
            out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4], out[i, 5], out[i, 6] = evaluate_flank(
                tables, cycle[i], delta[i], psi[i], pinion, wheel, none
            )

    return evaluate, evaluate_two, evaluate_shares, evaluate_many


def _source_digest() -> int:
    """Checksum of the files of this package: compiled code on disk knows only the file of the function itself."""
    total = 0
    for path in sorted(Path(__file__).parent.glob("*.py")):
        total = zlib.crc32(path.read_bytes(), total)
    return total


evaluate, evaluate_two, evaluate_shares, evaluate_many = _doors(_source_digest())
