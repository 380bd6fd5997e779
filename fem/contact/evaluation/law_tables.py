"""Constants of a mesh law as the compiled evaluation reads them: named arrays over slices, grid cells and variants.

`pack` lays them into one vector, so that a machine of many laws stays a plain array of numbers; `unpacked` names its
parts again in compiled code, where that costs nothing. Slices stand in blocks of LANES, which vector instructions take
together; the last block is filled up with copies of the last slice of width 0. Tables over the position grid hold, per
cell, the value at its lower end and the change over the cell.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba.np.unsafe.ndarray import to_fixed_tuple

from fem.contact.law import MeshLaw
from fem.contact.slice_means import FINER, slice_means
from fem.numerics.compiled import views
from fem.numerics.inner_functions import INLINE, inner

LANES = 16
MAX_SPAN = 10  # pitches that the position grid may span
LARGEST_NEAR = 64  # pairs in contact anywhere on the face


# Fields of a slice
Y, WIDTH = 0, 1  # m from mid face; m
SHIFT, PART, LEAD = 2, 3, 4  # mesh cycles; y / face width; lead gap, m
SPRING = 5  # m, a^2 / distance to the next slice; 0 behind the last
BEFORE, BEHIND = 6, 7  # m: the unloaded face before or behind the slice acts on it like this spring
FIELDS = 8


class LawTables(NamedTuple):
    """One mesh law; the symbols are those of `fem.contact.law`."""

    slices: float  # whole numbers, as all numbers of the vector are floats: slices of the face
    cells: float  # of the position grid
    neighbours: float  # tabulated neighbour compliances
    pinion_variants: float
    wheel_variants: float
    sign: float  # +1 drive, -1 coast
    offset: float  # c' = sign * c + offset
    start: float  # xi of the first grid point
    per_step: float  # grid points per pitch
    slope: float  # A, m2/N
    pulls: float  # 1 if some neighbour compliance is negative
    wheel_offset: float  # wheel tooth of pair p: sign * p + this
    first_shift: float  # least and largest shift of a slice
    last_shift: float
    coupled: float  # 1 if the slices are coupled along the face
    spread_length: float  # a, m; 0 without spread bending
    body: float  # E_0, m/N
    skew: float  # E_01, 1/N
    tilt: float  # E_1, 1/(N m)
    pinion_modes: float  # modes of a damaged tooth
    wheel_modes: float
    block: np.ndarray  # (block, field, lane) of the slices, see above
    coarse: np.ndarray  # (cell, 8) C (m2/N), B, phi (0 in a cell with an infinite gap), sqrt(D); value, change of each
    fine: np.ndarray  # (cell * FINER, 8) over a slice: mean gap (m), its rise over the least gap (m), load that closes
    # the slice wholly (N/m), part of the slice over which the gap is even; value and change of each
    neighbour: np.ndarray  # (cell, neighbour, 2) c_1, c_2, ..., m2/N
    pinion_softening: np.ndarray  # (variant, slice, position) compliance that a damaged tooth adds, m2/N
    pinion_gap: np.ndarray  # (variant, slice, position) m
    wheel_softening: np.ndarray
    wheel_gap: np.ndarray
    pinion_mode: np.ndarray  # (variant, near, slice, position, mode), (m/N)^(1/2)
    wheel_mode: np.ndarray


leading: Any = to_fixed_tuple  # the first numbers of a vector as a tuple
NUMBERS = LawTables._fields.index("block")
PINION_MODES = LawTables._fields.index("pinion_modes")


def pack(law: MeshLaw) -> np.ndarray:
    """All numbers (n,) of a law that has been checked, in the order of `LawTables`."""
    spread = law.spread_length > 0.0 and law.spread_compliance.max() > 0.0
    pinion_modes, wheel_modes = law.pinion_variant_modes.shape[1], law.wheel_variant_modes.shape[1]
    closed = ~(np.isfinite(law.gap[:-1]) & np.isfinite(law.gap[1:]))
    fraction, means = _cells(law.fraction), slice_means(law)
    fraction[closed] = 0.0
    tables = LawTables(
        slices=law.face_coordinate.size,
        cells=law.compliance.size - 1,
        neighbours=len(law.neighbour_compliance),
        pinion_variants=len(law.pinion_variant_gap),
        wheel_variants=len(law.wheel_variant_gap),
        sign=law.cycle_sign,
        offset=law.cycle_offset,
        start=law.position_start,
        per_step=1.0 / law.position_step,
        slope=law.contact_slope,
        pulls=float(law.neighbour_compliance.size > 0 and law.neighbour_compliance.min() < 0.0),
        wheel_offset=law.wheel_tooth_offset,
        first_shift=law.cycle_shift.min(),
        last_shift=law.cycle_shift.max(),
        coupled=float(spread or max(law.body_compliance, law.tilt_compliance) > 0.0 or pinion_modes + wheel_modes > 0),
        spread_length=law.spread_length if spread else 0.0,
        body=law.body_compliance,
        skew=law.skew_compliance,
        tilt=law.tilt_compliance,
        pinion_modes=pinion_modes,
        wheel_modes=wheel_modes,
        block=_blocks(law),
        coarse=np.hstack(
            [_cells(law.compliance), _cells(law.contact_offset), fraction, _cells(np.sqrt(law.spread_compliance))]
        ),
        fine=np.hstack([_cells(table) for table in (means.gap, means.rise, means.whole, means.even)]),
        neighbour=np.swapaxes(_cells(law.neighbour_compliance), 0, 1),
        pinion_softening=law.pinion_variant_compliance,
        pinion_gap=law.pinion_variant_gap,
        wheel_softening=law.wheel_variant_compliance,
        wheel_gap=law.wheel_variant_gap,
        pinion_mode=np.moveaxis(law.pinion_variant_modes, 1, -1),
        wheel_mode=np.moveaxis(law.wheel_variant_modes, 1, -1),
    )
    return np.concatenate([np.array(tables[:NUMBERS], dtype=float), *(np.ravel(array) for array in tables[NUMBERS:])])


def _cells(table: np.ndarray) -> np.ndarray:
    """Value at the lower end of each cell and change over it (..., cell, 2) of tables (..., position)."""
    return np.stack([table[..., :-1], np.diff(table)], axis=-1)


def _blocks(law: MeshLaw) -> np.ndarray:
    """Fields of the slices (block, field, lane)."""
    w, n = law.slice_width, law.slice_width.size
    spring, before, behind = np.zeros(n), np.zeros(n), np.zeros(n)
    spring[:-1] = law.spread_length**2 / np.diff(law.face_coordinate)
    for s in range(1, n):
        rest = w[s - 1] + before[s - 1]
        before[s] = spring[s - 1] * rest / (spring[s - 1] + rest)
    for s in range(n - 2, -1, -1):
        rest = w[s + 1] + behind[s + 1]
        behind[s] = spring[s] * rest / (spring[s] + rest)
    y = law.face_coordinate
    slices = np.array([y, w, law.cycle_shift, y / w.sum(), law.slice_lead_gap, spring, before, behind])
    blocks = -(-n // LANES)
    filled = slices[:, np.minimum(np.arange(blocks * LANES), n - 1)]
    filled[WIDTH, n:] = 0.0
    return np.swapaxes(filled.reshape(FIELDS, blocks, LANES), 0, 1)


@inner(**INLINE)
def blocks_of(packed):
    """Number of blocks of slices in the numbers (n,) of `pack`."""
    return (int(packed[0]) + LANES - 1) // LANES


@inner(**INLINE)
def unpacked(packed):
    """The `LawTables` in the numbers (n,) of `pack`."""
    numbers = leading(packed, NUMBERS)
    slices, cells, neighbours = int(numbers[0]), int(numbers[1]), int(numbers[2])
    first, second = int(numbers[3]), int(numbers[4])
    blocks = blocks_of(packed)
    at = NUMBERS + blocks * FIELDS * LANES
    block, coarse = views(packed, NUMBERS, 1, (blocks, FIELDS, LANES)), views(packed, at, 1, (cells, 8))
    at += 8 * cells
    fine = views(packed, at, 1, (FINER * cells, 8))
    at += 8 * FINER * cells
    neighbour = views(packed, at, 1, (cells, neighbours, 2))
    at += 2 * cells * neighbours
    pinion = views(packed, at, 2, (first, slices, cells + 1))
    at += 2 * first * slices * (cells + 1)
    wheel = views(packed, at, 2, (second, slices, cells + 1))
    at += 2 * second * slices * (cells + 1)
    of_pinion, of_wheel = int(numbers[PINION_MODES]), int(numbers[PINION_MODES + 1])
    pinion_mode = views(packed, at, 1, (first, 3, slices, cells + 1, of_pinion))
    at += first * 3 * slices * (cells + 1) * of_pinion
    wheel_mode = views(packed, at, 1, (second, 3, slices, cells + 1, of_wheel))
    return LawTables(*(numbers + block + coarse + fine + neighbour + pinion + wheel + pinion_mode + wheel_mode))
