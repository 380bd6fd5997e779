"""One flat array of numbers per mesh law, in the order in which the compiled evaluation reads them.

All laws share this one compiled type, whatever they hold, so a machine keeps them in a plain tuple of arrays. Behind a
header follow

    slices    per block of LANES slices: rows y, width, shift, y / b, lead gap, [least shift, largest shift],
              spring a^2 / distance to the next slice, stiffness of the unloaded face before the slice, behind it
    grid      per cell of the position grid: C, dC, B, dB, gap, dgap, phi, dphi, c_1, dc_1, c_2, ..., sqrt(D), change,
              at its lower end
    variants  per damaged tooth form and slice: what it adds to C and to the gap at the grid points
              (pinion forms, then wheel forms; each (2, slice, position))

The last block is filled up with copies of the last slice of width 0.
"""

from __future__ import annotations

import numpy as np

from fem.contact.law import MeshLaw

LANES = 16
MAX_PAIRS = 12  # pairs that the position grid may span
LARGEST_NEAR = 64  # pairs in contact anywhere on the face

# header
SLICES, POSITIONS, BLOCKS, REACH = range(4)
SIGN, OFFSET, START, PER_STEP = range(4, 8)
SLOPE, PULLS, WHEEL_OFFSET, FIRST_SHIFT, LAST_SHIFT = range(8, 13)
GRID, CELL, VARIANTS, WHEEL_VARIANTS = range(13, 17)
COUPLED, LENGTH, BODY, SKEW, TILT = range(17, 22)
SLICE_ROWS = 24  # where the rows of the slices begin
ROWS_PER_BLOCK = 9
Y, WIDTH, SHIFT, PART, LEAD, RANGE, SPRING, BEFORE, BEHIND = range(9)
C, B, GAP, PHI, NEXT = 0, 2, 4, 6, 8  # columns of the grid; each is followed by its change over the cell


def pack(law: MeshLaw) -> np.ndarray:
    """The flat array of a law that has been checked."""
    n = law.face_coordinate.size
    blocks = -(-n // LANES)
    fill = np.minimum(np.arange(blocks * LANES), n - 1)
    width = np.where(np.arange(blocks * LANES) < n, law.slice_width[fill], 0.0)
    face = float(law.slice_width.sum())
    y, shift, lead = law.face_coordinate[fill], law.cycle_shift[fill], law.lead_gap[fill]
    rows = np.zeros((blocks, ROWS_PER_BLOCK, LANES))
    for row, values in ((Y, y), (WIDTH, width), (SHIFT, shift), (PART, y / face), (LEAD, lead)):
        rows[:, row] = values.reshape(blocks, LANES)
    rows[:, RANGE, 0], rows[:, RANGE, 1] = rows[:, SHIFT].min(axis=1), rows[:, SHIFT].max(axis=1)
    rows[:, SPRING : BEHIND + 1] = _springs(law, blocks)
    grid = _cells(law)
    variants = [
        np.stack([compliance, gap], axis=1)
        for compliance, gap in (
            (law.pinion_variant_compliance, law.pinion_variant_gap),
            (law.wheel_variant_compliance, law.wheel_variant_gap),
        )
    ]
    header = np.zeros(SLICE_ROWS)
    header[[SLICES, POSITIONS, BLOCKS, REACH]] = n, law.compliance.size, blocks, law.neighbour_compliance.shape[0]
    header[[SIGN, OFFSET, START, PER_STEP]] = (
        law.cycle_sign,
        law.cycle_offset,
        law.position_start,
        1.0 / law.position_step,
    )
    header[SLOPE], header[WHEEL_OFFSET] = law.contact_slope, law.wheel_tooth_offset
    header[PULLS] = float(law.neighbour_compliance.size > 0 and law.neighbour_compliance.min() < 0.0)
    header[FIRST_SHIFT], header[LAST_SHIFT] = law.cycle_shift.min(), law.cycle_shift.max()
    spread = law.spread_length > 0.0 and law.spread_compliance.max() > 0.0
    header[COUPLED] = float(spread or law.body_compliance > 0.0 or law.tilt_compliance > 0.0)
    header[LENGTH] = law.spread_length if spread else 0.0
    header[[BODY, SKEW, TILT]] = law.body_compliance, law.skew_compliance, law.tilt_compliance
    header[GRID], header[CELL] = SLICE_ROWS + rows.size, grid.shape[1]
    header[VARIANTS] = header[GRID] + grid.size
    header[WHEEL_VARIANTS] = header[VARIANTS] + variants[0].size
    return np.concatenate([header, rows.ravel(), grid.ravel(), variants[0].ravel(), variants[1].ravel()])


def _springs(law: MeshLaw, blocks: int) -> np.ndarray:
    """Rows SPRING, BEFORE, BEHIND (block, 3, lane), m: an unloaded slice chain acts on its end like one spring."""
    w, n = law.slice_width, law.slice_width.size
    rows = np.zeros((3, blocks * LANES))
    if n > 1:
        rows[0, : n - 1] = law.spread_length**2 / np.diff(law.face_coordinate)
    for s in range(1, n):
        q, rest = rows[0, s - 1], w[s - 1] + rows[1, s - 1]
        rows[1, s] = q * rest / (q + rest)
    for s in range(n - 2, -1, -1):
        q, rest = rows[0, s], w[s + 1] + rows[2, s + 1]
        rows[2, s] = q * rest / (q + rest)
    return rows.reshape(3, blocks, LANES).swapaxes(0, 1)


def _cells(law: MeshLaw) -> np.ndarray:
    """Values at the lower end of each cell and their changes over it; a cell with an infinite gap carries nothing."""
    closed = ~(np.isfinite(law.gap[:-1]) & np.isfinite(law.gap[1:]))
    gap = np.where(np.isfinite(law.gap), law.gap, 0.0)
    columns = []
    for table in (
        law.compliance,
        law.contact_offset,
        gap,
        law.fraction,
        *law.neighbour_compliance,
        np.sqrt(law.spread_compliance),
    ):
        columns += [table[:-1].copy(), np.diff(table)]
    for column in (PHI, PHI + 1):
        columns[column][closed] = 0.0
    return np.column_stack(columns)
