"""Sixteen slices and the tooth pairs that approach there, compiled: what the law says of them at one position.

Every quantity of the pairs is an array (row, lane), so that the compiler turns loops over the lanes into vector
instructions. Pair p stands in row p mod rows; a slice with two pairs for one row needs more rows.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import types

from fem.contact.evaluation.law_tables import LANES, slices_of
from fem.contact.slice_means import FINER
from fem.numerics.compiled import FLOAT, INLINE, INTEGER, inner, views

NEVER = -1e300  # approach of a pair that cannot touch
LEAST = 1e-290  # N/m: the load that closes a slice with an even gap


class States(NamedTuple):
    """One or two states at one mesh cycle; a single state is given twice."""

    cycle: float  # c
    delta: float  # m
    psi: float  # rad
    other_delta: float
    other_psi: float
    asked: int  # 1 or 2


class Rows(NamedTuple):
    """Arrays (row, lane), or as noted; a row without a pair has x = NEVER, phi = 0, C = 1."""

    order: tuple[int, ...]  # as long as there are rows: a tuple where the compiler may unroll loops over them
    memory: np.ndarray  # (number,) all of it
    pair: np.ndarray  # number p
    place: np.ndarray  # position in cells of the grid
    approach: np.ndarray  # x, m
    gap_slope: np.ndarray  # d(gap)/d(xi), m
    fraction: np.ndarray  # phi
    fraction_slope: np.ndarray
    compliance: np.ndarray  # C, m2/N
    compliance_slope: np.ndarray
    offset: np.ndarray  # B
    offset_slope: np.ndarray
    rise: np.ndarray  # a of `fem.contact.part_contact`, m
    rise_slope: np.ndarray
    per_whole: np.ndarray  # 1 / f_a, m/N
    whole_slope: np.ndarray
    even: np.ndarray  # p
    even_slope: np.ndarray
    load: np.ndarray  # f, N/m; 1 where a pair does not carry while loads are sought, else 0
    log: np.ndarray  # ln f
    on: np.ndarray  # 1 where the pair carries
    beyond: np.ndarray  # t of `hertz`
    rest: np.ndarray  # right-hand sides
    neighbour: np.ndarray  # (row, row, lane) c_pq, m2/N
    neighbour_slope: np.ndarray  # (row, row, lane)
    pull: np.ndarray  # (row, row, lane) c_pq phi_q where both carry
    system: np.ndarray  # (row, row, lane) matrix, then its inverse
    y: np.ndarray  # (lane,) m from mid face
    width: np.ndarray  # (lane,) m, 0 in lanes without a slice
    step: np.ndarray  # (lane,) square of the last relative step
    rare: np.ndarray  # (lane,) 1 where the vector iteration does not hold


STATES = types.NamedTuple((FLOAT, FLOAT, FLOAT, FLOAT, FLOAT, INTEGER), States)


@inner(**INLINE)
def rows_room(n):
    """Numbers of memory for n rows."""
    return (21 * n + 4 * n * n + 4) * LANES


@inner(**INLINE)
def rows_in(memory, at, order):
    """`Rows` in the numbers of memory (k,) from `at` on."""
    n, whole = len(order), views(memory, at, 1, (rows_room(len(order)),))
    at_pairs, at_lanes = at + 21 * n * LANES, at + (21 * n + 4 * n * n) * LANES
    by_row, by_pair = views(memory, at, 21, (n, LANES)), views(memory, at_pairs, 4, (n, n, LANES))
    return Rows(order, *(whole + by_row + by_pair + views(memory, at_lanes, 4, (LANES,))))


@inner(**INLINE)
def state_of(states, which):
    """delta and psi of state 0 or 1."""
    return (states.delta, states.psi) if which == 0 else (states.other_delta, states.other_psi)


@inner(**INLINE)
def state_alone(states, which):
    """State 0 or 1 as a single one."""
    delta, psi = state_of(states, which)
    return States(states.cycle, delta, psi, delta, psi, 1)


@inner(**INLINE)
def largest_approach(states, y):
    """The larger approach of the two states at face coordinate y."""
    return max(states.delta + states.psi * y, states.other_delta + states.other_psi * y)


@inner(**INLINE)
def gather(law, near, block, own_cycle, states, lowest, rows):
    """Fill the rows with the pairs whose free approach exceeds `lowest` in one of two states.

    Returns the rows that are needed: 0 where nothing approaches, more than there are where two pairs of a slice ask for
    one row; the rows are not complete then.

    Parameters
    ----------
    law, near : `LawTables`; `NearPairs` at own_cycle
    block : number of the block of slices
    own_cycle : c' of the law
    states : `States`
    lowest : m
    rows : `Rows` of the block, out; `approach` belongs to the larger approach
    """
    slices, n, found = slices_of(law, block), len(rows.order), 0
    reach, per_step = int(law.neighbours), law.per_step
    _clear(rows)
    for s in range(LANES):
        rows.y[s], rows.width[s] = slices.y[s], slices.width[s]
        here = own_cycle + slices.shift[s]
        approach = largest_approach(states, slices.y[s]) - slices.lead[s]
        for m in range(near.pairs if slices.width[s] > 0.0 else 0):
            x, cell, u = _free_approach(law, near, m, here, slices.part[s], approach)
            fine, v = _finer(cell, u)
            rise = law.rise[fine, 0] + v * law.rise[fine, 1]
            if not x + rise > lowest:
                continue
            number = int(near.number[m])
            a = number % n
            if rows.approach[a, s] > NEVER:
                return n + 1
            softening = softening_slope = gap_slope = 0.0
            if near.pinion_variant[m] != 0.0 or near.wheel_variant[m] != 0.0:
                damage = _damaged(law, near, m, block * LANES + s, cell, u)
                softening, softening_slope, gap_slope = damage[0], damage[1], damage[3]
                x -= damage[2]
                if not x + rise > lowest:
                    continue
            xi = here - number
            slope = near.profile_slope[m] + 2.0 * near.profile_curvature[m] * xi
            rows.pair[a, s], rows.place[a, s], rows.approach[a, s] = number, cell + u, x
            rows.gap_slope[a, s] = law.gap[fine, 1] * FINER * per_step + slope + gap_slope
            rows.fraction[a, s] = law.fraction[cell, 0] + u * law.fraction[cell, 1]
            rows.fraction_slope[a, s] = law.fraction[cell, 1] * per_step
            rows.compliance[a, s] = law.compliance[cell, 0] + u * law.compliance[cell, 1] + softening
            rows.compliance_slope[a, s] = law.compliance[cell, 1] * per_step + softening_slope
            rows.offset[a, s] = law.contact_offset[cell, 0] + u * law.contact_offset[cell, 1]
            rows.offset_slope[a, s] = law.contact_offset[cell, 1] * per_step
            whole = law.whole[fine, 0] + v * law.whole[fine, 1]
            if whole > 0.0:
                rows.rise[a, s], rows.rise_slope[a, s] = rise, law.rise[fine, 1] * FINER * per_step
                rows.per_whole[a, s], rows.whole_slope[a, s] = 1.0 / whole, law.whole[fine, 1] * FINER * per_step
                rows.even[a, s] = law.even[fine, 0] + v * law.even[fine, 1]
                rows.even_slope[a, s] = law.even[fine, 1] * FINER * per_step
            found = n
            for b in range(n):
                apart = number - int(rows.pair[b, s])
                if b != a and rows.approach[b, s] > NEVER and apart <= reach:
                    k, v = cell_of(law, rows.place[b, s])
                    value, change = law.neighbour[k, apart - 1, 0], law.neighbour[k, apart - 1, 1]
                    rows.neighbour[a, b, s] = rows.neighbour[b, a, s] = value + v * change
                    rows.neighbour_slope[a, b, s] = rows.neighbour_slope[b, a, s] = change * per_step
    return found


@inner(**INLINE)
def _clear(rows):
    """Rows without pairs."""
    n = len(rows.order)
    for a in range(n):
        for s in range(LANES):
            rows.approach[a, s], rows.pair[a, s], rows.compliance[a, s], rows.offset[a, s] = NEVER, 0.0, 1.0, 2.0
            rows.gap_slope[a, s] = rows.fraction[a, s] = rows.fraction_slope[a, s] = 0.0
            rows.compliance_slope[a, s] = rows.offset_slope[a, s] = rows.place[a, s] = 0.0
            rows.rise[a, s] = rows.rise_slope[a, s] = rows.whole_slope[a, s] = 0.0
            rows.per_whole[a, s], rows.even[a, s], rows.even_slope[a, s] = 1.0 / LEAST, 0.0, 0.0
        for b in range(n):
            for s in range(LANES):
                rows.neighbour[a, b, s] = rows.neighbour_slope[a, b, s] = 0.0


@inner(**INLINE)
def cell_of(law, place):
    """The grid cell of a position counted in cells, and the place inside it."""
    cell = min(int(place), int(law.cells) - 1)
    return cell, place - cell


@inner(**INLINE)
def _finer(cell, u):
    """The cell of the finer grid of the gap, and the place inside it."""
    k = min(int(FINER * u), FINER - 1)
    return FINER * cell + k, FINER * u - k


@inner(**INLINE)
def _free_approach(law, near, m, here, part, approach):
    """Free approach x (m) of near pair m at xi = here - p (NEVER out of reach), its grid cell, place inside the cell.

    `approach` (m) is delta + psi y less the lead gap, `part` y over the face width; teeth are taken as sound.
    """
    xi = here - near.number[m]
    place = (xi - law.start) * law.per_step
    if not (place >= 0.0 and place <= law.cells):
        return NEVER, 0, 0.0
    cell, u = cell_of(law, place)
    if law.fraction[cell, 0] + u * law.fraction[cell, 1] <= 0.0:
        return NEVER, 0, 0.0
    fine, v = _finer(cell, u)
    x = approach - law.gap[fine, 0] - v * law.gap[fine, 1] - near.clearance[m]
    x -= xi * (near.profile_slope[m] + xi * near.profile_curvature[m])
    return x - part * (near.lead_slope[m] + part * near.lead_curvature[m]), cell, u


@inner()
def nearest_approach(law, near, own_cycle, psi):
    """The largest free approach (m) of all pairs and slices at delta = 0; -inf if none can touch.

    Parameters
    ----------
    law, near, own_cycle : as for `gather`
    psi : tilt, rad
    """
    largest = -math.inf
    for block in range(len(law.block)):
        slices = slices_of(law, block)
        for s in range(LANES):
            approach = psi * slices.y[s] - slices.lead[s]
            for m in range(near.pairs if slices.width[s] > 0.0 else 0):
                x, cell, u = _free_approach(law, near, m, own_cycle + slices.shift[s], slices.part[s], approach)
                if x > NEVER and (near.pinion_variant[m] != 0.0 or near.wheel_variant[m] != 0.0):
                    x -= _damaged(law, near, m, block * LANES + s, cell, u)[2]
                fine, v = _finer(cell, u)
                touch = x + law.rise[fine, 0] + v * law.rise[fine, 1]
                largest = max(largest, touch) if x > NEVER else largest
    return largest


@inner(**INLINE)
def _damaged(law, near, m, number, cell, u):
    """What the damaged teeth of near pair m add in slice `number`: compliance, its slope by xi, gap, its slope."""
    compliance = compliance_slope = gap = gap_slope = 0.0
    for softening, opening, variant in (
        (law.pinion_softening, law.pinion_gap, int(near.pinion_variant[m])),
        (law.wheel_softening, law.wheel_gap, int(near.wheel_variant[m])),
    ):
        if variant > 0:
            soft, soft_next = softening[variant - 1, number, cell], softening[variant - 1, number, cell + 1]
            open_, open_next = opening[variant - 1, number, cell], opening[variant - 1, number, cell + 1]
            if open_ == math.inf or open_next == math.inf:
                return 0.0, 0.0, math.inf, 0.0
            compliance, gap = compliance + soft + u * (soft_next - soft), gap + open_ + u * (open_next - open_)
            compliance_slope += (soft_next - soft) * law.per_step
            gap_slope += (open_next - open_) * law.per_step
    return compliance, compliance_slope, gap, gap_slope


@inner(**INLINE)
def invert(order, matrix, s):
    """Inverse of the matrix (row, row) of lane s in place, without pivoting."""
    n = len(order)
    if n == 2:
        a, b, c, d = matrix[0, 0, s], matrix[0, 1, s], matrix[1, 0, s], matrix[1, 1, s]
        scale = 1.0 / (a * d - b * c)
        matrix[0, 0, s], matrix[0, 1, s], matrix[1, 0, s], matrix[1, 1, s] = (
            d * scale,
            -b * scale,
            -c * scale,
            a * scale,
        )
        return
    for k in range(n):
        pivot = 1.0 / matrix[k, k, s]
        matrix[k, k, s] = 1.0
        for j in range(n):
            matrix[k, j, s] *= pivot
        for i in range(n):
            if i != k:
                factor = matrix[i, k, s]
                matrix[i, k, s] = 0.0
                for j in range(n):
                    matrix[i, j, s] -= factor * matrix[k, j, s]
