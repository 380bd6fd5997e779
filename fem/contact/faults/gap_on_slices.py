"""Gaps of damage on a part of the face, converted to the slices of a mesh law.

The face is cut at the edges of the slices, at the ends of the damage, and SUBDIVISIONS times within each slice. Each
part has one gap at its position on the path of contact. The parts i of a slice, of widths w_i, carry loads in
proportion to max(0, x - g_i) at the approach x. The gap g of the slice is the one for which the slice carries the same
load where the mean of these values is X:

    sum_i w_i max(0, X + g - g_i) = X sum_i w_i         g = min_n (X W + sum_{i<n} w_i g_i) / sum_{i<n} w_i - X

with the parts in ascending order of their gaps and the whole width W. A uniformly covered slice has its gap, and
shallow damage has the mean of the gaps. Where deep damage leaves only a part of the slice in contact, its load is exact
at X, the approach of a flank under a usual load; X affects only partly covered slices. The gap is continuous and
increases with the width and depth of damage.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from fem.contact.law import MeshLaw
from fem.gears.geometry import GearPair

SUBDIVISIONS = 8  # of a slice
USUAL_APPROACH = 0.002  # X in m_n: the local part of an approach, without bodies and spreading tooth bending


@dataclass(frozen=True, eq=False, kw_only=True)
class FaceParts:
    """Parts of the face: their slices, centres y and widths (part,), m, and positions xi (part, position)."""

    slice: np.ndarray
    face: np.ndarray
    width: np.ndarray
    xi: np.ndarray


def gap_on_slices(
    law: MeshLaw, pair: GearPair, ends: Iterable[float], gap: Callable[[FaceParts], np.ndarray]
) -> np.ndarray:
    """Gap (slice, position), m, of damage on parts of the face.

    Parameters
    ----------
    law, pair : of one flank, and its gears
    ends : face coordinates (m) at which damage begins or ends
    gap : of parts of the face, (part, position), m, >= 0 or inf
    """
    parts = face_parts(law, pair, ends)
    gaps = gap(parts)
    usual = USUAL_APPROACH * pair.pinion.normal_module
    found = np.zeros((law.face_coordinate.size, law.compliance.size))
    for s in np.unique(parts.slice[(gaps > 0.0).any(axis=1)]):
        own = parts.slice == s
        found[s] = _even_gap(gaps[own], parts.width[own], usual)
    return found


def face_parts(law: MeshLaw, pair: GearPair, ends: Iterable[float]) -> FaceParts:
    """The parts of the face; arguments as in `gap_on_slices`."""
    edges = np.concatenate([[0.0], np.cumsum(law.slice_width)]) - law.slice_width.sum() / 2
    within = np.linspace(edges[:-1], edges[1:], SUBDIVISIONS + 1)
    cuts = np.unique(np.concatenate([within.ravel(), np.clip(np.array(list(ends), dtype=float), edges[0], edges[-1])]))
    middle, width = (cuts[1:] + cuts[:-1]) / 2, np.diff(cuts)
    number = np.clip(np.searchsorted(edges, middle) - 1, 0, len(edges) - 2)
    lead = law.cycle_sign * pair.pinion.hand_sign * math.tan(pair.base_helix_angle) / pair.base_pitch
    grid = law.position_start + law.position_step * np.arange(law.compliance.size)
    apart = lead * (middle - law.face_coordinate[number])
    return FaceParts(slice=number, face=middle, width=width, xi=grid + apart[:, None])


def _even_gap(gaps: np.ndarray, width: np.ndarray, usual: float) -> np.ndarray:
    """The gap (position,) of a slice with gaps (part, position) over parts of widths (part,), see above."""
    order = np.argsort(gaps, axis=0)
    risen, widths = np.take_along_axis(gaps, order, axis=0), width[order]
    carried = np.cumsum(widths, axis=0)
    lost = np.cumsum(widths * risen, axis=0)
    even: np.ndarray = ((usual * width.sum() + lost) / carried).min(axis=0) - usual
    return np.maximum(even, 0.0)
