"""What a slice as a whole meets: its mean gap, what the mean exceeds the least by, and the load that closes it wholly.

While the end of a line of contact lies in a slice, the gap there runs from less to more than the approach. A law that
knows no more than the gap in the middle takes the slice in and out of contact as a whole, and all slices in turn,
n / eps_beta to a mesh cycle, make a tone. What the slice does between first touch and closing stands in
`fem.contact.part_contact`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import simpson
from scipy.interpolate import PchipInterpolator

from fem.contact.law import MeshLaw

FINER = 4  # the gap is curved where it decides: straight pieces of the law's own grid would make a tone, too
PLACES = 17  # in a slice, at which its gap is read
EVEN = 1e-12  # m: a gap that varies less is the same everywhere in a slice
ROUNDS = 40


class SliceMeans(NamedTuple):
    """Arrays (position,) over a grid FINER times as fine as that of the law, and a number."""

    gap: np.ndarray  # m, mean over the slice about the position; 0 outside the finite gaps of the law
    rise: np.ndarray  # m, mean less least gap
    whole: np.ndarray  # N/m, line load at which the largest gap is closed; 0 where the gap is even
    bend: float  # half the relative change of x / f with ln f at these loads, of the Hertz term


def slice_means(law: MeshLaw) -> SliceMeans:
    """Means over the slices of a law, which are as wide as they are apart; beyond its ends the gap goes on straight."""
    at = np.arange(law.gap.size)
    xi, here = np.arange((law.gap.size - 1) * FINER + 1) / FINER, np.isfinite(law.gap)
    gap, rise, whole = np.zeros((3, xi.size))
    if np.count_nonzero(here) < 2:
        return SliceMeans(gap, rise, whole, 0.0)
    inside = (xi >= at[here][0]) & (xi <= at[here][-1])
    values = _gap(law, at[here], law.gap[here], xi[inside])
    gap[inside] = simpson(values, axis=1) / (PLACES - 1)
    above = values.max(axis=1) - gap[inside]
    uneven = inside.copy()
    uneven[inside] = np.ptp(values, axis=1) > EVEN
    rise[uneven] = np.maximum(gap[inside] - values.min(axis=1), 0.0)[uneven[inside]]
    most = np.maximum(above[uneven[inside]], EVEN)
    slope, compliance, offset = (
        law.contact_slope,
        *(np.interp(xi[uneven], at, table) for table in (law.compliance, law.contact_offset)),
    )
    load = most / (compliance + slope * np.maximum(offset, 1.0))
    for _ in range(ROUNDS):
        load = most / (compliance + slope * np.maximum(offset - np.log(load), 1.0))
    whole[uneven] = load
    return SliceMeans(gap, rise, whole, float(np.mean(0.5 * slope * load / most)) if load.size else 0.0)


def _gap(law: MeshLaw, at: np.ndarray, gap: np.ndarray, xi: np.ndarray) -> np.ndarray:
    """Gap (position, PLACES), m, at the places of slices about xi; at, xi in steps of the grid."""
    slices = law.cycle_shift.size
    half = float(np.ptp(law.cycle_shift)) / (2 * max(slices - 1, 1)) / law.position_step
    far = max(half, 1.0)
    first, last = gap[0] - far * (gap[1] - gap[0]), gap[-1] + far * (gap[-1] - gap[-2])
    curve = PchipInterpolator(np.array([at[0] - far, *at, at[-1] + far]), np.array([first, *gap, last]))
    return curve(xi[:, None] + np.linspace(-half, half, PLACES))
