"""Slices of a face and the tooth pairs that approach there, compiled: their terms of the law at one position.

All numbers of an evaluation are one array ``r`` (block, row, field, lane). Slices are in blocks of LANES, which vector
instructions take together. Pair p of a slice is in row p mod rows; a slice with two pairs for one row needs more rows.
The fields are numbered below; those of row b seen from row a are PAIR_FIELDS * b further, those of mode k of damaged
teeth at `mode_field`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fem.contact.evaluation.law_tables import BEFORE, BEHIND, LANES, LARGEST_NEAR, LEAD, PART, SHIFT, SPRING, WIDTH, Y
from fem.contact.slice_means import FINER
from fem.numerics.compiled import views
from fem.numerics.inner_functions import INLINE, inner

NEVER = -1e300  # approach of a pair that cannot touch
LEAST = 1e-290  # N/m: the load that closes a slice with an even gap
BODIES = 2  # displacements that all contacts share: wind-up d (m) and tilt t (rad)

# Fields of a row. A row without a pair has PHI = 0, FREE = NEVER, SOFTNESS = 1.
PAIR, PLACE = 0, 1  # number p; position in cells of the grid
FREE = 2  # free approach, m
PHI = 3  # fraction
SOFTNESS, OFFSET = 4, 5  # C, m2/N, and B
RISE, PER_WHOLE, EVEN = 6, 7, 8  # a (m), 1 / f_a (m/N) and p of `fem.contact.part_contact`
GAIN = 9  # g = sqrt(D)
LINK = 10  # spring to the next slice, m; 0 where another line lies there
STAY = 11  # width and springs of a slice, m
LOAD, LOG, ON = 12, 13, 14  # f (N/m; 1 where the pair does not carry), ln f, 1 where the pair carries
BEYOND = 15  # t of `line_contact`
FIELD = 16  # v
MOVED = 17  # what fields, bodies and modes take from the approach, m
TARGET = 18  # l: loads after a Newton step of the slice by itself at the free approach
RIGHT_LOAD, RIGHT_BODY, RIGHT_TILT = 19, 20, 21  # right sides of the field equations: w g phi l, w g K 1, w g K y
FROM_LOAD, FROM_BODY, FROM_TILT = 22, 23, 24  # what they give while slices nearer the middle are held
REST = 25
FIELD_BEFORE, MOVED_BEFORE = 26, 27  # before the last step
BEND = 28  # a / (2 (1 - p)^2), m
RETURNED = 29  # approach to the least gap where a pair has just come back into contact, else 0, m
ROW_FIELDS = 30
# Fields of a row and row b, from PAIR_FIELDS * b on: c_pq; J, then its inverse; K; field equations
COUPLED, SYSTEM, STIFFNESS, PIVOT = ROW_FIELDS, ROW_FIELDS + 1, ROW_FIELDS + 2, ROW_FIELDS + 3
PAIR_FIELDS = 4
MODE, MODE_RIGHT, MODE_FROM = 0, 1, 2  # of a mode: what a unit takes from the approach; as RIGHT_ and FROM_LOAD
MODE_FIELDS = 3


class NearPairs(NamedTuple):
    """Pairs in rising order, arrays (pair,); the terms of both teeth of a pair are added, see `fem.contact.teeth`."""

    pairs: int
    number: np.ndarray  # p
    clearance: np.ndarray  # h, m
    profile_slope: np.ndarray  # a1, m
    profile_curvature: np.ndarray  # a2, m
    lead_slope: np.ndarray  # b1, m
    lead_curvature: np.ndarray  # b2, m
    pinion_variant: np.ndarray  # 0 for an undamaged tooth
    wheel_variant: np.ndarray


NEAR_ROOM = LARGEST_NEAR * (len(NearPairs._fields) - 1)  # numbers of memory


@inner(**INLINE)
def fields_of(rows, modes):
    """Number of fields of a row."""
    return ROW_FIELDS + PAIR_FIELDS * rows + MODE_FIELDS * modes


@inner(**INLINE)
def mode_field(rows, k, kind):
    """Field of mode k: MODE, MODE_RIGHT or MODE_FROM."""
    return ROW_FIELDS + PAIR_FIELDS * rows + MODE_FIELDS * k + kind


@inner(**INLINE)
def near_range(law, own_cycle):
    """First and last pair that may touch somewhere on the face at c' = own_cycle."""
    first = math.ceil(own_cycle + law.first_shift - law.start - law.cells / law.per_step)
    return first, min(math.floor(own_cycle + law.last_shift - law.start), first + LARGEST_NEAR - 1)


@inner(**INLINE)
def near_pairs(law, own_cycle, pinion, wheel, memory):
    """The pairs with both teeth that may touch somewhere on the face.

    Parameters
    ----------
    law : `LawTables`
    own_cycle : c' of the law
    pinion, wheel : (z1, 6) and (z2, 6) tooth terms, see `fem.contact.teeth`
    memory : (n,) out: the first NEAR_ROOM numbers hold the arrays
    """
    table = views(memory, 0, 8, (LARGEST_NEAR,))
    sign = 1 if law.sign > 0.0 else -1
    z1, z2 = pinion.shape[0], wheel.shape[0]
    first, last = near_range(law, own_cycle)
    i, j = (sign * first) % z1, (sign * first + int(law.wheel_offset)) % z2
    n = 0
    for p in range(first, last + 1):
        if pinion[i, 0] + wheel[j, 0] < math.inf:
            table[0][n] = p
            for k in range(5):
                table[1 + k][n] = pinion[i, k] + wheel[j, k]
            table[6][n], table[7][n] = pinion[i, 5], wheel[j, 5]
            n += 1
        i, j = i + sign, j + sign
        i, j = i - z1 if i >= z1 else i, j - z2 if j >= z2 else j
        i, j = i + z1 if i < 0 else i, j + z2 if j < 0 else j
    return NearPairs(n, *table)


@inner(**INLINE)
def clear(rows, r):
    """Rows without pairs."""
    for block in range(r.shape[0]):
        for a in range(rows):
            for s in range(LANES):
                r[block, a, PAIR, s] = r[block, a, PLACE, s] = r[block, a, PHI, s] = r[block, a, GAIN, s] = 0.0
                r[block, a, RISE, s] = r[block, a, EVEN, s] = r[block, a, LINK, s] = r[block, a, STAY, s] = 0.0
                r[block, a, BEND, s] = 0.0
                r[block, a, FIELD, s] = r[block, a, MOVED, s] = r[block, a, FROM_LOAD, s] = 0.0
                r[block, a, FROM_BODY, s] = r[block, a, FROM_TILT, s] = 0.0  # in lanes without a slice, too
                r[block, a, FREE, s], r[block, a, SOFTNESS, s], r[block, a, OFFSET, s] = NEVER, 1.0, 2.0
                r[block, a, PER_WHOLE, s], r[block, a, BEYOND, s] = 1.0 / LEAST, 1.0
            for b in range(rows):
                for s in range(LANES):
                    r[block, a, COUPLED + PAIR_FIELDS * b, s] = 0.0


@inner(**INLINE)
def gather(law, near, own_cycle, delta, psi, lowest, rows, r):
    """Fill the rows with the pairs whose free approach exceeds `lowest`.

    Returns the rows that are needed: 0 where nothing approaches, more than there are where two pairs of a slice ask for
    one row; the rows are not complete then.

    Parameters
    ----------
    law, near : `LawTables`; `NearPairs` at own_cycle
    own_cycle : c' of the law
    delta, psi, lowest : m, rad, m
    rows, r : number of rows; the array of all fields, out
    """
    found, reach, face = 0, int(law.neighbours), law.block
    clear(rows, r)
    for block in range(r.shape[0]):
        for s in range(LANES):
            here, approach = own_cycle + face[block, SHIFT, s], delta + psi * face[block, Y, s] - face[block, LEAD, s]
            for m in range(near.pairs if face[block, WIDTH, s] > 0.0 else 0):
                x, cell, u = _free_approach(law, near, m, here, face[block, PART, s], approach)
                fine, v = finer(cell, u)
                rise = law.fine[fine, 2] + v * law.fine[fine, 3]
                if not x + rise > lowest:
                    continue
                softening = 0.0
                if near.pinion_variant[m] != 0.0 or near.wheel_variant[m] != 0.0:
                    softening, gap = damage_at(law, near, m, block * LANES + s, cell, u)
                    x -= gap
                    if not x + rise > lowest:
                        continue
                number = int(near.number[m])
                a = number % rows
                if r[block, a, PHI, s] > 0.0:
                    return rows + 1
                r[block, a, PAIR, s], r[block, a, PLACE, s], r[block, a, FREE, s] = number, cell + u, x
                r[block, a, SOFTNESS, s] = law.coarse[cell, 0] + u * law.coarse[cell, 1] + softening
                r[block, a, OFFSET, s] = law.coarse[cell, 2] + u * law.coarse[cell, 3]
                r[block, a, PHI, s] = law.coarse[cell, 4] + u * law.coarse[cell, 5]
                r[block, a, GAIN, s] = law.coarse[cell, 6] + u * law.coarse[cell, 7]
                whole = law.fine[fine, 4] + v * law.fine[fine, 5]
                if whole > 0.0:
                    r[block, a, RISE, s], r[block, a, PER_WHOLE, s] = rise, 1.0 / whole
                    even = law.fine[fine, 6] + v * law.fine[fine, 7]
                    r[block, a, EVEN, s], r[block, a, BEND, s] = even, 0.5 * rise / ((1.0 - even) * (1.0 - even))
                found = rows
                for b in range(rows if reach > 0 else 0):
                    apart = number - int(r[block, b, PAIR, s])
                    if b != a and r[block, b, PHI, s] > 0.0 and apart <= reach:
                        k, v = cell_of(law, r[block, b, PLACE, s])
                        value = law.neighbour[k, apart - 1, 0] + v * law.neighbour[k, apart - 1, 1]
                        r[block, a, COUPLED + PAIR_FIELDS * b, s] = r[block, b, COUPLED + PAIR_FIELDS * a, s] = value
    if found > 0 and law.spread_length > 0.0 and not _link(law, rows, r):
        return rows + 1
    return found


@inner(**INLINE)
def _link(law, rows, r):
    """Springs between the slices that one line runs through; False where a line comes back after another.

    The line of pair p is its trace over the face. Row a holds the lines of all pairs p with p mod rows = a, one behind
    the other. The part of a line before its first and behind its last slice acts like one spring (fields BEFORE and
    BEHIND).
    """
    good, count = True, int(law.slices)
    for a in range(rows):
        last, number, direction = -1, 0.0, 0.0
        for s in range(count):
            if r[s // LANES, a, PHI, s % LANES] > 0.0:
                found = r[s // LANES, a, PAIR, s % LANES]
                if last >= 0 and found == number:
                    for j in range(last, s):
                        r[j // LANES, a, LINK, j % LANES] = law.block[j // LANES, SPRING, j % LANES]
                elif last >= 0:
                    good = good and direction * (found - number) >= 0.0
                    direction = found - number
                last, number = s, found
        for block in range(r.shape[0]):
            for s in range(LANES):
                ahead = r[block, a, LINK, s]
                behind = r[block, a, LINK, s - 1] if s > 0 else (r[block - 1, a, LINK, LANES - 1] if block > 0 else 0.0)
                stay = law.block[block, WIDTH, s] + (behind if behind > 0.0 else law.block[block, BEFORE, s])
                r[block, a, STAY, s] = stay + (ahead if ahead > 0.0 else law.block[block, BEHIND, s])
    return good


@inner(**INLINE)
def cell_of(law, place):
    """The grid cell of a position counted in cells, and the place inside it."""
    cell = min(int(place), int(law.cells) - 1)
    return cell, place - cell


@inner(**INLINE)
def finer(cell, u):
    """The cell of the finer grid of the gap, and the place inside it."""
    k = min(int(FINER * u), FINER - 1)
    return FINER * cell + k, FINER * u - k


@inner(**INLINE)
def _free_approach(law, near, m, here, part, approach):
    """Free approach x (m) of near pair m at xi = here - p (NEVER out of reach), its grid cell, place inside the cell.

    `approach` (m) is delta + psi y less the lead gap, `part` y over the face width; teeth are taken as undamaged.
    """
    xi = here - near.number[m]
    place = (xi - law.start) * law.per_step
    if not (place >= 0.0 and place <= law.cells):
        return NEVER, 0, 0.0
    cell, u = cell_of(law, place)
    if law.coarse[cell, 4] + u * law.coarse[cell, 5] <= 0.0:
        return NEVER, 0, 0.0
    fine, v = finer(cell, u)
    x = approach - law.fine[fine, 0] - v * law.fine[fine, 1] - near.clearance[m]
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
    largest, face = -math.inf, law.block
    for block in range(len(face)):
        for s in range(LANES):
            here, approach = own_cycle + face[block, SHIFT, s], psi * face[block, Y, s] - face[block, LEAD, s]
            for m in range(near.pairs if face[block, WIDTH, s] > 0.0 else 0):
                x, cell, u = _free_approach(law, near, m, here, face[block, PART, s], approach)
                if x > NEVER and (near.pinion_variant[m] != 0.0 or near.wheel_variant[m] != 0.0):
                    x -= damage_at(law, near, m, block * LANES + s, cell, u)[1]
                fine, v = finer(cell, u)
                touch = x + law.fine[fine, 2] + v * law.fine[fine, 3]
                largest = max(largest, touch) if x > NEVER else largest
    return largest


@inner(**INLINE)
def damage_at(law, near, m, number, cell, u):
    """What the damaged teeth of a near pair add in a slice: compliance (m2/N) and gap (m).

    Parameters
    ----------
    law, near : `LawTables`, `NearPairs`
    m, number : of the near pair and of the slice
    cell, u : grid cell of the pair, and its place inside it
    """
    compliance = gap = 0.0
    for softening, opening, variant in (
        (law.pinion_softening, law.pinion_gap, int(near.pinion_variant[m])),
        (law.wheel_softening, law.wheel_gap, int(near.wheel_variant[m])),
    ):
        if variant > 0:
            soft, soft_next = softening[variant - 1, number, cell], softening[variant - 1, number, cell + 1]
            open_, open_next = opening[variant - 1, number, cell], opening[variant - 1, number, cell + 1]
            if open_ == math.inf or open_next == math.inf:
                return 0.0, math.inf
            compliance, gap = compliance + soft + u * (soft_next - soft), gap + open_ + u * (open_next - open_)
    return compliance, gap


@inner()
def damaged_teeth(law, own_cycle, pinion, wheel, found):
    """Number of the teeth with modes on the pairs near mesh and next to them.

    Parameters
    ----------
    law, own_cycle, pinion, wheel : as for `near_pairs`
    found : (n, 3) out: pair, 0 pinion or 1 wheel, variant; (0, 0) if only their number is needed
    """
    sign, count = 1 if law.sign > 0.0 else -1, 0
    first, last = near_range(law, own_cycle)
    for p in range(first - 1, min(last + 1, first + LARGEST_NEAR - 2) + 1):
        of_pinion = pinion[(sign * p) % pinion.shape[0], 5] if law.pinion_modes > 0.0 else 0.0
        of_wheel = wheel[(sign * p + int(law.wheel_offset)) % wheel.shape[0], 5] if law.wheel_modes > 0.0 else 0.0
        for gear, variant in ((0.0, of_pinion), (1.0, of_wheel)):
            if variant > 0.0:
                if found.size > 0:
                    found[count, 0], found[count, 1], found[count, 2] = p, gear, variant
                count += 1
    return count


@inner(**INLINE)
def mode_at(law, tooth, pair, number, cell, k):
    """Mode of a damaged tooth at both ends of a grid cell, (m/N)^(1/2); 0 for pairs further away than the next.

    Parameters
    ----------
    law : `LawTables`
    tooth : (3,) row of `damaged_teeth`
    pair, number, cell, k : of the pair, the slice, the cell and the mode
    """
    side = int(pair - tooth[0]) + 1
    if side < 0 or side > 2:
        return 0.0, 0.0
    variant = int(tooth[2]) - 1
    if tooth[1] == 0.0:
        return law.pinion_mode[variant, side, number, cell, k], law.pinion_mode[variant, side, number, cell + 1, k]
    return law.wheel_mode[variant, side, number, cell, k], law.wheel_mode[variant, side, number, cell + 1, k]


@inner(**INLINE)
def gather_modes(law, teeth, rows, r):
    """What a unit of every mode of the damaged teeth takes from the approaches of the gathered rows.

    Parameters
    ----------
    law : `LawTables`
    teeth : (n, 3) from `damaged_teeth`
    rows, r : as for `gather`, filled
    """
    at = 0
    for i in range(len(teeth)):
        for k in range(int(law.pinion_modes if teeth[i, 1] == 0.0 else law.wheel_modes)):
            for block in range(r.shape[0]):
                for a in range(rows):
                    for s in range(LANES):
                        value = 0.0
                        if r[block, a, PHI, s] > 0.0:
                            cell, u = cell_of(law, r[block, a, PLACE, s])
                            low, high = mode_at(law, teeth[i], r[block, a, PAIR, s], block * LANES + s, cell, k)
                            value = low + u * (high - low)
                        r[block, a, mode_field(rows, at, MODE), s] = value
                        r[block, a, mode_field(rows, at, MODE_FROM), s] = 0.0
            at += 1
