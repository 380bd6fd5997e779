"""Means over a slice: its mean gap, the difference to the least gap, its uniformity, and the load of full contact.

While the end of a contact line is in a slice, the gap is below the approach on one part of it and above on the other.
With only the gap at the centre, slices would come into contact as a whole, one after the other, and slicing would cause
spurious excitation at n / eps_beta per mesh cycle. `fem.contact.part_contact` models the partial contact by a gap that
is constant over a share p of the slice and increases linearly over the rest. Its mean m above the least gap and its
mean square m2 are those of the true gap, which gives m2 / m^2 = 4 / (3 (1 - p)).

Slices wider than `WIDEST` keep the gap at their centre, because their gap is too nonlinear for this model. The mean
transmission error would be 3 to 5 % too small for slices of 0.5 mesh cycles (eps_beta 7.3, 15 slices), and 0.2 to 0.8 %
for 0.12 cycles. Whole slices have more spurious excitation but the correct mean.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fem.contact.law import MeshLaw
from fem.numerics.pchip import pchip

FINER = 4  # resolves the curved gap: linear interpolation on the grid of the law causes spurious excitation too
PLACES = 17  # points in a slice for its gap; odd
EVEN = 1e-12  # m: a gap with less variation is constant in a slice
MOST_EVEN = 0.95  # largest p; the rest of a slice at a steep end is neglected
WIDEST = 0.1  # mesh cycles
NARROWEST = 0.5  # steps of the grid of the law
CLOSED = 1e-9  # fraction of a slice below which it is round-off
ROUNDS = 40


class SliceMeans(NamedTuple):
    """Arrays (position,) over a grid FINER times as fine as that of the law."""

    gap: np.ndarray  # m, mean over the slice around the position; 0 where no contact is possible
    rise: np.ndarray  # m, mean minus least gap
    even: np.ndarray  # share of the slice with constant gap
    whole: np.ndarray  # N/m, line load of full contact; 0 where the gap is constant


def slice_means(law: MeshLaw) -> SliceMeans:
    """Means over the slices of a law; the gap itself for slices wider than `WIDEST`.

    A law with partial slices (`iso`, whose fraction is 0 where its gap jumps) has a separate interval of the grid for
    each kind of contact. Beyond an interval its gap is constant towards another interval, else extrapolated linearly.
    """
    at = np.arange(law.gap.size)
    stretches = _stretches(law)
    xi = np.arange((law.gap.size - 1) * FINER + 1) / FINER
    gap, rise, even = np.zeros((3, xi.size))
    for first, last in stretches:
        inside = slice(FINER * first, FINER * last + 1)
        here = slice(first, last + 1)
        straight = first == stretches[0][0], last == stretches[-1][1]
        values = _gap(law, at[here], law.gap[here], xi[inside], straight)
        over = values - values.min(axis=1, keepdims=True)
        mean, square = _mean(over), _mean(over**2)
        uneven = over.max(axis=1) > EVEN
        gap[inside] = values.min(axis=1) + np.where(uneven, mean, 0.0)
        rise[inside] = np.where(uneven, mean, 0.0)
        even[inside] = np.clip(1.0 - 4.0 * mean**2 / (3.0 * np.where(uneven, square, np.inf)), 0.0, MOST_EVEN)
    even[rise == 0.0] = 0.0
    return SliceMeans(gap, rise, even, _closing_loads(law, at, xi, rise * (1.0 + even) / (1.0 - even)))


def _mean(values: np.ndarray) -> np.ndarray:
    """Mean over the points (position, PLACES) of slices, by Simpson's rule."""
    parabolas = values[:, :-2:2] + 4.0 * values[:, 1:-1:2] + values[:, 2::2]
    return np.asarray(parabolas.sum(axis=1) * (1.0 / 3.0) / (PLACES - 1))


def _stretches(law: MeshLaw) -> list[tuple[int, int]]:
    """First and last grid points of the intervals with finite gaps in which every cell can be in contact."""
    finite = np.isfinite(law.gap)
    open_cells = finite[:-1] & finite[1:] & (np.maximum(law.fraction[:-1], law.fraction[1:]) > CLOSED)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], open_cells, [False]]).astype(int)))
    return [(int(first), int(last)) for first, last in ends.reshape(-1, 2)]


def _closing_loads(law: MeshLaw, at: np.ndarray, xi: np.ndarray, above: np.ndarray) -> np.ndarray:
    """Line loads (position,) at which the approach to the mean gap is `above`, m; 0 where that is 0."""
    whole, uneven = np.zeros(xi.size), above > 0.0
    slope, most = law.contact_slope, above[uneven]
    compliance, offset = (np.interp(xi[uneven], at, table) for table in (law.compliance, law.contact_offset))
    load = most / (compliance + slope * np.maximum(offset, 1.0))
    for _ in range(ROUNDS):
        load = most / (compliance + slope * np.maximum(offset - np.log(load), 1.0))
    whole[uneven] = load
    return whole


def _gap(law: MeshLaw, at: np.ndarray, gap: np.ndarray, xi: np.ndarray, straight: tuple[bool, bool]) -> np.ndarray:
    """Gap (position, PLACES), m, at the points of slices around xi; at, xi in steps of the grid.

    Slices narrower than half a step of the grid (spur gears) and wider than `WIDEST` have a constant gap.

    straight : whether it is extrapolated linearly before the first and after the last of its points
    """
    width = float(np.ptp(law.cycle_shift)) / max(law.cycle_shift.size - 1, 1)
    half = width / 2 / law.position_step
    if not NARROWEST * law.position_step < width <= WIDEST:
        return np.broadcast_to(np.interp(xi, at, gap)[:, None], (xi.size, PLACES))
    far = max(half, 1.0)
    first = gap[0] - straight[0] * far * (gap[1] - gap[0])
    last = gap[-1] + straight[1] * far * (gap[-1] - gap[-2])
    places = xi[:, None] + np.linspace(-half, half, PLACES)
    return pchip(np.array([at[0] - far, *at, at[-1] + far]), np.array([first, *gap, last]), places)
