"""First touch of the flanks without load, at the points of the face instead of the means of its slices.

At the face coordinate y the tooth pair p is at xi = c' - p + shift(y) and has the gap

    g(y) = gap(xi) + lead_gap(y) + h_p(xi, y)

The flanks touch at the tilt psi where delta = min (g - psi y) over all pairs and the whole face. Where the moment is
zero instead, delta is the largest of these minima over psi: the lower convex envelope of g at mid face.

The points are both ends of each slice, the points of the lead gap, and the grid points of the law, which hold the ends
of the contact lines. Between them g is linear, but for the curvature that single teeth have. Gaps of damaged teeth
are those of their slices.
"""

from __future__ import annotations

import math

import numpy as np

from fem.contact.law import MeshLaw

NEVER = 1e300  # gap, m, where no contact is possible
ON_PATH = 0.5 - 1e-9  # fraction of a slice whose middle is at the end of the path of contact, less rounding


def first_touch(
    law: MeshLaw, cycle: np.ndarray, psi: float | None, pinion: np.ndarray, wheel: np.ndarray
) -> np.ndarray:
    """delta_0 (n,) in m; about NEVER where no pair can touch.

    Parameters
    ----------
    law : of one flank
    cycle : (n,) mesh cycles
    psi : tilt, rad; None for the tilt at which the moment is zero
    pinion, wheel : (z1, 6) and (z2, 6) tooth terms, see `fem.contact.teeth`
    """
    found = np.empty(len(cycle))
    for i, own_cycle in enumerate(law.cycle_sign * cycle + law.cycle_offset):
        y, gap = _gaps(law, float(own_cycle), pinion, wheel)
        found[i] = _envelope(y, gap) if psi is None else (gap - psi * y).min()
    return found


def _gaps(law: MeshLaw, own_cycle: float, pinion: np.ndarray, wheel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Face coordinates (n,), m, and gaps (n,), m, of the points of all pairs."""
    face, shift, count = law.face_coordinate, law.cycle_shift, law.face_coordinate.size
    edges = face[0] - law.slice_width[0] / 2 + np.concatenate([[0.0], np.cumsum(law.slice_width)])
    twist = float(shift[-1] - shift[0]) / float(face[-1] - face[0]) if count > 1 else 0.0
    grid = law.position_start + law.position_step * np.arange(law.gap.size)
    here = own_cycle + shift[0] + twist * (edges[[0, -1]] - face[0])
    pairs = np.arange(math.ceil(here.min() - grid[-1]), math.floor(here.max() - grid[0]) + 1)[:, None]
    fixed = np.concatenate([edges[:-1], edges[1:], law.lead_coordinate])
    at_grid = face[0] + (grid + pairs - own_cycle - shift[0]) / twist if twist else np.empty((len(pairs), 0))
    y = np.clip(np.hstack([np.tile(fixed, (len(pairs), 1)), at_grid]), edges[0], edges[-1])
    number = np.clip(np.searchsorted(edges, y, side="right") - 1, 0, count - 1)
    number[:, count : 2 * count] = np.arange(count)  # the upper end of a slice is not the lower end of the next
    xi = own_cycle - pairs + shift[0] + twist * (y - face[0])
    gap = np.interp(xi, grid, _finite(law.gap), left=NEVER, right=NEVER) + np.interp(
        y, law.lead_coordinate, law.lead_gap
    )
    gap[np.interp(xi, grid, law.fraction) < ON_PATH] = NEVER
    part = y / law.slice_width.sum()
    for terms, variants, offset in (
        (pinion, law.pinion_variant_gap, 0),
        (wheel, law.wheel_variant_gap, law.wheel_tooth_offset),
    ):
        h, a1, a2, b1, b2, variant = terms[(law.cycle_sign * pairs + offset) % len(terms)].transpose(2, 0, 1)
        gap += _finite(h) + xi * (a1 + xi * a2) + part * (b1 + part * b2)
        for row in np.flatnonzero(variant):
            places = own_cycle - pairs[row] + shift
            tables = _finite(variants[int(variant[row, 0]) - 1])
            own = [np.interp(place, grid, table) for place, table in zip(places, tables, strict=True)]
            gap[row] += np.array(own)[number[row]]
    return y.ravel(), gap.ravel()


def _finite(gap: np.ndarray) -> np.ndarray:
    """Gaps with NEVER for inf, which can be interpolated."""
    return np.minimum(gap, NEVER)


def _envelope(y: np.ndarray, gap: np.ndarray) -> float:
    """Lower convex envelope at y = 0 of points (n,): the chord over 0 is lowered until no point lies below it."""
    left, right = (int(np.argmin(np.where(side, gap, np.inf))) for side in (y <= 0.0, y >= 0.0))
    while True:
        slope = (gap[right] - gap[left]) / max(y[right] - y[left], 1e-300)
        above = gap - slope * y
        lowest = int(np.argmin(above))
        if above[lowest] >= min(above[left], above[right]):
            return float(above[lowest])
        left, right = (lowest, right) if y[lowest] <= 0.0 else (left, lowest)
