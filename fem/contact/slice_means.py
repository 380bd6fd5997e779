"""What a slice as a whole meets: its mean gap, what that exceeds the least by, how even it is, and what closes it.

While the end of a line of contact lies in a slice, the gap there runs from less to more than the approach. A law that
knows no more than the gap in the middle takes the slice in and out of contact as a whole, and all slices in turn,
n / eps_beta to a mesh cycle, make a tone. What the slice does between first touch and closing stands in
`fem.contact.part_contact`: a gap that is even over a part p of the slice and rises evenly over the rest, with the mean
m over the least and the mean square m2 of the true one. For those, m2 / m^2 = 4 / (3 (1 - p)).

Slices wider than `WIDEST` are left as they are. Their gap rises too unevenly for that: at eps_beta 7.3 and 15 slices,
0.5 mesh cycles each, the mean transmission error became 3 to 5 % too small, at 0.12 cycles 0.2 to 0.8 %, where whole
slices, which ring more, have it right on average.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fem.contact.law import MeshLaw
from fem.numerics.pchip import pchip

FINER = 4  # the gap is curved where it decides: straight pieces of the law's own grid would make a tone, too
PLACES = 17  # in a slice, at which its gap is read; odd
EVEN = 1e-12  # m: a gap that varies less is the same everywhere in a slice
MOST_EVEN = 0.95  # what is left of a slice that only just meets a steep end counts for nothing
WIDEST = 0.1  # mesh cycles
NARROWEST = 0.5  # steps of the grid of the law
CLOSED = 1e-9  # fraction of a slice that is rounding
ROUNDS = 40


class SliceMeans(NamedTuple):
    """Arrays (position,) over a grid FINER times as fine as that of the law."""

    gap: np.ndarray  # m, mean over the slice about the position; 0 where no slice can be in contact
    rise: np.ndarray  # m, mean less least gap
    even: np.ndarray  # part of the slice over which the gap is even
    whole: np.ndarray  # N/m, line load at which the slice is wholly in contact; 0 where the gap is even


def slice_means(law: MeshLaw) -> SliceMeans:
    """Means over the slices of a law, which are as wide as they are apart; the gap itself in slices above `WIDEST`.

    A law that cuts slices itself (`iso`, whose fraction falls to 0 where its gap jumps) has a stretch of the grid for
    each kind of contact. Each is taken by itself: towards another one its gap stays as it is, else it goes on straight.
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
    """Mean over the places (position, PLACES) of slices, by Simpson's rule."""
    parabolas = values[:, :-2:2] + 4.0 * values[:, 1:-1:2] + values[:, 2::2]
    return np.asarray(parabolas.sum(axis=1) * (1.0 / 3.0) / (PLACES - 1))


def _stretches(law: MeshLaw) -> list[tuple[int, int]]:
    """First and last grid points of the stretches with finite gaps and no cell that is never in contact."""
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
    """Gap (position, PLACES), m, at the places of slices about xi; at, xi in steps of the grid.

    Slices narrower than half a step of the grid (spur gears) and wider than `WIDEST` have one gap all over.

    straight : whether it goes on straight before the first and behind the last of its points
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
