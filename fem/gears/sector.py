"""Structured mesh of one pitch of a toothed ring: a tooth and the body under it, down to the bore.

Nine-node quadrilaterals with curved edges on the true profile. Frame of the sector: origin on the gear axis, tooth
centre line along +x, the loaded flank at y > 0. Two grids in polar coordinates share the circle through the middle of
the fillet (slope 45 degrees there, so that no corner is sharper than 45 degrees):

    tooth  rows follow circles, fine along the flank, columns grow away from the loaded flank
    body   columns span the whole pitch, layers grow from the root to the bore

Both cut lines (mid tooth space) carry the same radii, so that sectors join conformingly to a ring.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from fem.gears.gear import Gear
from fem.gears.profile import flank_at_roll, form_radius, half_tooth_profile, roll_length

_FILLET_POINTS = 400  # points from which the fillet is interpolated


@dataclass(frozen=True, eq=False, kw_only=True)
class SectorMesh:
    """One pitch of a gear. All lengths m; index arrays point into `points`."""

    teeth: int
    twist: float  # rad/m, 2 pi / lead of the helix
    points: np.ndarray  # (nodes, 2)
    elements: np.ndarray  # (elements, 9), tensor order
    bore: np.ndarray  # nodes held rigid, without those on the cut lines
    cut_low: np.ndarray  # nodes of the cut at -pi/z, root to bore, without the bore node
    cut_high: np.ndarray  # same radii at +pi/z
    cut_bore: np.ndarray  # the two bore nodes of the cuts
    flank: np.ndarray  # nodes of the loaded side from mid fillet to tip corner, two intervals per element
    flank_arc: np.ndarray  # (flank,) arc length along the involute from its base circle, negative below
    flank_normal: np.ndarray  # (flank, 2) unit, out of the tooth
    base_radius: float
    form_arc: float  # arc length at the form circle, where the involute starts
    tip_arc: float  # arc length at the tip corner


@dataclass(frozen=True)
class _Fillet:
    """The fillet by arc length, 0 at mid space and `length` at the form circle."""

    radius: CubicSpline
    angle: CubicSpline
    length: float
    middle: float  # where the slope against the radius is 45 degrees

    @staticmethod
    def of(gear: Gear) -> _Fillet:
        half = half_tooth_profile(gear, _FILLET_POINTS, 1, 1)
        x, y = half.points[: half.form_index + 1].T  # tooth centre line along +y there
        radius, angle = np.hypot(x, y), np.arctan2(x, y)
        arc = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
        rise, run = np.diff(radius), -np.diff(angle) * (radius[1:] + radius[:-1]) / 2
        flat = np.flatnonzero(rise < run)  # slope flatter than 45 degrees against the circle
        middle = float(np.clip(arc[flat[-1] + 1], 0.3 * arc[-1], 0.9 * arc[-1]))
        return _Fillet(CubicSpline(arc, radius), CubicSpline(arc, angle), float(arc[-1]), middle)


def with_middles(ends: np.ndarray) -> np.ndarray:
    """Element ends with the element middles between them."""
    out = np.empty(2 * len(ends) - 1)
    out[::2] = ends
    out[1::2] = (ends[1:] + ends[:-1]) / 2
    return out


def growing(first: float, growth: float, largest: float, total: float) -> np.ndarray:
    """Element ends 0 .. total whose sizes start near `first` and grow by `growth` up to `largest`."""
    sizes = [first]
    while sum(sizes) < total:
        sizes.append(min(sizes[-1] * growth, largest))
    ends = np.concatenate([[0.0], np.cumsum(sizes)])
    return ends * (total / ends[-1])


def sector_mesh(gear: Gear, refinement: float = 1.0) -> SectorMesh:
    """Mesh one pitch of `gear`.

    Element sizes are divided by `refinement`; 1: 0.05 m_n along the flank, half of that at the tip corner.
    """
    size = gear.normal_module / refinement
    fillet = _Fillet.of(gear)
    r_b, r_bore = gear.base_radius, gear.bore_radius

    # rows of the tooth: from the middle of the fillet to the form circle, then along the involute to the tip
    form_arc = roll_length(gear, form_radius(gear)) ** 2 / (2 * r_b)
    tip_arc = roll_length(gear, gear.tip_radius) ** 2 / (2 * r_b)
    lower = with_middles(np.linspace(fillet.middle, fillet.length, _count(fillet.length - fillet.middle, 0.08 * size)))
    upper = with_middles(tip_arc - growing(0.025 * size, 1.15, 0.05 * size, tip_arc - form_arc)[::-1])
    upper[[0, -1]] = form_arc, tip_arc
    point, radius, normal = flank_at_roll(gear, np.sqrt(2 * r_b * upper))
    flank_radius = np.concatenate([fillet.radius(lower[:-1]), radius])
    flank_angle = np.concatenate([fillet.angle(lower[:-1]), np.arctan2(point[:, 0], point[:, 1])])
    flank_arc = np.concatenate([form_arc - fillet.length + lower[:-1], upper])
    flank_normal = np.vstack([_fillet_normal(fillet, lower[:-1]), normal[:, ::-1]])

    # columns of the tooth: from +1 on the loaded flank to -1
    thickness = flank_radius[len(lower) :].mean() * flank_angle[len(lower) :].mean()
    across = with_middles(growing(0.05 * size / thickness, 1.25, 0.3 / refinement, 2.0)) - 1.0  # -1 = loaded here
    across = -across[::-1]  # rises to the loaded side
    tooth_r = np.broadcast_to(flank_radius[:, None], (len(flank_radius), len(across)))
    tooth_t = flank_angle[:, None] * across[None, :]

    # columns of the body: cut, root land, under the tooth, root land, cut
    land = with_middles(np.linspace(0.0, fillet.middle, _count(fillet.middle, 0.12 * size)))
    top_r = np.concatenate(
        [fillet.radius(land[:-1]), np.full(len(across), flank_radius[0]), fillet.radius(land[-2::-1])]
    )
    top_t = np.concatenate([-fillet.angle(land[:-1]), flank_angle[0] * across, fillet.angle(land[-2::-1])])
    top_r[[0, -1]], top_t[0], top_t[-1] = gear.root_radius, -math.pi / gear.teeth, math.pi / gear.teeth
    even_t = np.linspace(-1.0, 1.0, len(top_t)) * math.pi / gear.teeth
    depth = flank_radius[0] - r_bore
    layer = with_middles(growing(0.18 * size, 1.25, depth / 6 / refinement, depth) / depth)[:, None]
    body_r = top_r + layer * (r_bore - top_r)
    body_t = top_t + layer * (even_t - top_t)

    body = np.arange(body_r.size).reshape(body_r.shape)
    tooth = np.empty(tooth_r.shape, dtype=int)
    first = len(land) - 1
    tooth[0] = body[0, first : first + len(across)]
    tooth[1:] = body.size + np.arange(tooth[1:].size).reshape(tooth[1:].shape)
    r = np.concatenate([body_r.ravel(), tooth_r[1:].ravel()])
    t = np.concatenate([body_t.ravel(), tooth_t[1:].ravel()])
    return SectorMesh(
        teeth=gear.teeth,
        twist=math.tan(gear.helix_angle) / gear.reference_radius,
        points=np.column_stack([r * np.cos(t), r * np.sin(t)]),
        elements=np.vstack([_quads(body[::-1]), _quads(tooth)]),
        bore=body[-1, 1:-1].copy(),
        cut_low=body[:-1, 0].copy(),
        cut_high=body[:-1, -1].copy(),
        cut_bore=body[-1, [0, -1]].copy(),
        flank=tooth[:, -1].copy(),
        flank_arc=flank_arc,
        flank_normal=flank_normal,
        base_radius=r_b,
        form_arc=form_arc,
        tip_arc=tip_arc,
    )


def _count(length: float, size: float) -> int:
    """Number of element ends that divide `length` into elements of at most `size` (at least 3 elements)."""
    return max(3, math.ceil(length / size)) + 1


def _fillet_normal(fillet: _Fillet, arc: np.ndarray) -> np.ndarray:
    """Unit normal out of the tooth (x, y) on the fillet of the loaded side."""
    rise, turn = fillet.radius(arc, 1), fillet.radius(arc) * fillet.angle(arc, 1)
    along, angle = np.column_stack([rise, turn]) / np.hypot(rise, turn)[:, None], fillet.angle(arc)
    radial = np.column_stack([np.cos(angle), np.sin(angle)])
    around = np.column_stack([-np.sin(angle), np.cos(angle)])
    return -along[:, 1:] * radial + along[:, :1] * around


def _quads(nodes: np.ndarray) -> np.ndarray:
    """Elements (n, 9) of a node grid with odd counts; the first grid axis is radial, outwards."""
    windows = np.lib.stride_tricks.sliding_window_view(nodes, (3, 3))[::2, ::2]
    return windows.reshape(-1, 9)
