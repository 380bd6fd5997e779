"""Structured mesh of one pitch of a toothed ring: a tooth and the body under it, down to the bore.

The mesh has nine-node quadrilaterals with curved edges on the exact profile. Its frame has the origin on the gear axis,
the tooth centre line along +x and the loaded flank at y > 0. Two grids in polar coordinates share the circle through
the middle of the fillet (slope 45 degrees there, so that no corner is sharper than 45 degrees):

    tooth  rows follow circles, fine along the flank; columns become wider away from the loaded flank
    body   columns span the whole pitch; layers become thicker from the root to the bore

Both cut lines (mid tooth space) have nodes at the same radii, so that sectors form a conforming ring. Below a rim the
body is a web: its elements fill the share b_s / b of the face width (an equivalent ring of modulus E b_s / b).

A slit, for a root crack, starts at the middle of the loaded fillet. The common line of the two grids follows it, the
grid of the tooth above is stretched accordingly, and the nodes on it are duplicated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fem.gears.gear import Gear
from fem.gears.profile import flank_at_roll, form_radius, half_tooth_profile, roll_length
from fem.numerics.quadratic_grids import cells_of, with_middles

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

_FILLET_POINTS = 400  # points for the interpolation of the fillet


@dataclass(frozen=True, eq=False, kw_only=True)
class SectorMesh:
    """One pitch of a gear. All lengths m; index arrays point into `points`."""

    teeth: int
    twist: float  # rad/m, 2 pi / lead of the helix
    points: np.ndarray  # (nodes, 2)
    elements: np.ndarray  # (elements, 9), tensor order
    grid: np.ndarray  # (elements, 2), row from the bore outwards and column from the low cut
    bore: np.ndarray  # rigidly held nodes, without those on the cut lines
    cut_low: np.ndarray  # nodes of the cut at -pi/z, root to bore, without the bore node
    cut_high: np.ndarray  # same radii at +pi/z
    cut_bore: np.ndarray  # the two bore nodes of the cuts
    fillet: np.ndarray  # nodes of the loaded side from one element below mid fillet to the form circle, likewise
    flank: np.ndarray  # nodes of the loaded side from mid fillet to tip corner, two intervals per element
    flank_arc: np.ndarray  # (flank,) arc length along the involute from its base circle, negative below
    flank_normal: np.ndarray  # (flank, 2) unit, out of the tooth
    base_radius: float
    form_arc: float  # arc length at the form circle, where the involute starts
    tip_arc: float  # arc length at the end of the involute
    filling: np.ndarray  # (elements,) filled share of the face width: 1, in a web b_s / b
    web: np.ndarray  # bool (elements,), below the rim
    slit: np.ndarray  # nodes of the tooth on the slit, mouth first, without its tip; empty without a slit
    slit_first: int  # index of the first of their duplicates, which belong to the body; len(points) without a slit

    def closed(self) -> SectorMesh:
        """The same mesh with the slit closed: duplicate nodes merged."""
        elements = self.elements.copy()
        doubled = elements >= self.slit_first
        elements[doubled] = self.slit[elements[doubled] - self.slit_first]
        return replace(self, points=self.points[: self.slit_first], elements=elements, slit=self.slit[:0])


@dataclass(frozen=True, kw_only=True)
class Slit:
    """A straight slit from the middle of the loaded fillet into the tooth: depth (m), angle to the centre line (rad).

    The angle pi/2 is straight across the tooth; a smaller one points down into the rim. Elements on the slit are small
    at mouth and tip, or of uniform size if `spacing` (m, approximate) is given: a crack may then end anywhere on it.
    """

    depth: float
    angle: float
    spacing: float | None = None


@dataclass(frozen=True)
class _Fillet:
    """The fillet by arc length, 0 at mid space and `length` at the form circle."""

    radius: CubicSpline
    angle: CubicSpline
    length: float
    middle: float  # where the slope relative to the radius is 45 degrees

    @staticmethod
    def of(gear: Gear) -> _Fillet:
        from scipy.interpolate import CubicSpline  # imported here: reports import this file and would take 0.3 s longer

        arc, radius, angle, middle = _fillet_points(gear)
        return _Fillet(CubicSpline(arc, radius), CubicSpline(arc, angle), float(arc[-1]), middle)


def _fillet_points(gear: Gear) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Arc length, radius and angle of points of the fillet, and the arc length of its middle, see `_Fillet`."""
    x, y = half_tooth_profile(gear, _FILLET_POINTS, 1, 1)[: _FILLET_POINTS + 1].T  # tooth along +y there
    radius, angle = np.hypot(x, y), np.arctan2(x, y)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    rise, run = np.diff(radius), -np.diff(angle) * (radius[1:] + radius[:-1]) / 2
    flat = np.flatnonzero(rise < run)  # slope less than 45 degrees relative to the circle
    return arc, radius, angle, float(np.clip(arc[flat[-1] + 1], 0.3 * arc[-1], 0.9 * arc[-1]))


def _growing(first: float, growth: float, largest: float, total: float) -> np.ndarray:
    """Element ends 0 .. total with sizes from about `first`, increasing by the factor `growth` up to `largest`."""
    sizes = [first]
    while sum(sizes) < total:
        sizes.append(min(sizes[-1] * growth, largest))
    ends = np.concatenate([[0.0], np.cumsum(sizes)])
    return ends * (total / ends[-1])


def root_chord(gear: Gear) -> tuple[float, float]:
    """Radius of the circle through the middle of both fillets and the tooth's width there (chord), m."""
    arc, radii, angles, middle = _fillet_points(gear)
    radius = float(np.interp(middle, arc, radii))  # the middle is a point, except in very flat or steep fillets
    return radius, 2.0 * radius * math.sin(float(np.interp(middle, arc, angles)))


def sector_mesh(
    gear: Gear, refinement: float = 1.0, slit: Slit | None = None, layers: tuple[float, float] = (0.18, 1.25)
) -> SectorMesh:
    """Mesh one pitch of `gear`, with a slit in the root of the loaded flank if one is given.

    Parameters
    ----------
    gear : meshed gear
    refinement : divides the element sizes; 1: 0.05 m_n along the flank, half of that at the tip corner
    slit : crack
    layers : size of the first layer of the body, in m_n, and growth of the next ones
    """
    size = gear.normal_module / refinement
    fillet = _Fillet.of(gear)
    r_b, r_bore = gear.base_radius, gear.bore_radius

    # rows of the tooth: from the middle of the fillet to the form circle, then along the involute to the tip
    form_arc = roll_length(gear, form_radius(gear)) ** 2 / (2 * r_b)
    tip_arc = roll_length(gear, gear.tip_form_radius) ** 2 / (2 * r_b)
    lower = with_middles(np.linspace(fillet.middle, fillet.length, _count(fillet.length - fillet.middle, 0.08 * size)))
    upper = with_middles(tip_arc - _growing(0.025 * size, 1.15, 0.05 * size, tip_arc - form_arc)[::-1])
    upper[[0, -1]] = form_arc, tip_arc
    point, radius, normal = flank_at_roll(gear, np.sqrt(2 * r_b * upper))
    flank_radius = np.concatenate([fillet.radius(lower[:-1]), radius])
    flank_angle = np.concatenate([fillet.angle(lower[:-1]), np.arctan2(point[:, 0], point[:, 1])])
    flank_arc = np.concatenate([form_arc - fillet.length + lower[:-1], upper])
    flank_normal = np.vstack([_fillet_normal(fillet, lower[:-1]), normal[:, ::-1]])

    # columns of the tooth: from -1 to +1 on the loaded flank
    if slit is None:
        thickness = flank_radius[len(lower) :].mean() * flank_angle[len(lower) :].mean()
        across = with_middles(_growing(0.05 * size / thickness, 1.25, 0.3 / refinement, 2.0)) - 1.0  # -1 = loaded here
        across = -across[::-1]  # ascending to the loaded side
        line_r, line_t = np.full(len(across), flank_radius[0]), flank_angle[0] * across
        cracked = np.zeros(len(across), dtype=bool)
    else:
        line, across, cracked = _slit_line(flank_radius[0], flank_angle[0], slit, size)
        line_r, line_t = np.hypot(*line.T), np.arctan2(line[:, 1], line[:, 0])
    tooth_r = np.broadcast_to(flank_radius[:, None], (len(flank_radius), len(across)))
    tooth_t = flank_angle[:, None] * across[None, :]
    if slit is not None:
        tooth_r, tooth_t = _stretched(tooth_r, tooth_t, line)

    # columns of the body: cut, root land, under the tooth, root land, cut
    land = with_middles(np.linspace(0.0, fillet.middle, _count(fillet.middle, 0.12 * size)))
    top_r = np.concatenate([fillet.radius(land[:-1]), line_r, fillet.radius(land[-2::-1])])
    top_t = np.concatenate([-fillet.angle(land[:-1]), line_t, fillet.angle(land[-2::-1])])
    top_r[[0, -1]], top_t[0], top_t[-1] = gear.root_radius, -math.pi / gear.teeth, math.pi / gear.teeth
    even_t = np.linspace(-1.0, 1.0, len(top_t)) * math.pi / gear.teeth
    inner = max(gear.rim_inner_radius, r_bore)
    depth = flank_radius[0] - inner
    layer = with_middles(_growing(layers[0] * size, layers[1], depth / 6 / refinement, depth) / depth)[:, None]
    body_r = top_r + layer * (inner - top_r)
    body_t = top_t + layer * (even_t - top_t)
    rim_rows = (len(layer) - 1) // 2
    if inner > r_bore:
        web = with_middles(np.linspace(inner, r_bore, 1 + max(3, math.ceil(6 * refinement))))[1:, None]
        body_r = np.vstack([body_r, np.broadcast_to(web, (len(web), body_r.shape[1]))])
        body_t = np.vstack([body_t, np.broadcast_to(even_t, (len(web), body_r.shape[1]))])

    body = np.arange(body_r.size).reshape(body_r.shape)
    tooth = np.empty(tooth_r.shape, dtype=int)
    first = len(land) - 1
    tooth[0] = body[0, first : first + len(across)]
    tooth[1:] = body.size + np.arange(tooth[1:].size).reshape(tooth[1:].shape)
    r = np.concatenate([body_r.ravel(), tooth_r[1:].ravel()])
    t = np.concatenate([body_t.ravel(), tooth_t[1:].ravel()])
    points = np.column_stack([r * np.cos(t), r * np.sin(t)])
    on_slit = tooth[0, cracked][::-1].copy()
    lower_side = body.copy()
    lower_side[0, first : first + len(across)][cracked] = len(points) + np.arange(len(on_slit))[::-1]
    quads = [cells_of(nodes).reshape(-1, 9) for nodes in (lower_side[::-1], tooth)]
    below, above = (np.argwhere(np.ones((len(n) // 2, len(n[0]) // 2))) for n in (body, tooth))
    web_elements = np.zeros(len(quads[0]) + len(quads[1]), dtype=bool)
    web_elements[: len(quads[0]) - rim_rows * ((len(body[0]) - 1) // 2)] = True  # inner rows come first
    return SectorMesh(
        teeth=gear.teeth,
        twist=math.tan(gear.helix_angle) / gear.reference_radius,
        points=np.vstack([points, points[on_slit]]),
        elements=np.vstack(quads),
        grid=np.vstack([below, above + (len(body) // 2, first // 2)]),
        bore=body[-1, 1:-1].copy(),
        cut_low=body[:-1, 0].copy(),
        cut_high=body[:-1, -1].copy(),
        cut_bore=body[-1, [0, -1]].copy(),
        fillet=np.append(tooth[0, -1] + [2, 1], tooth[: len(lower), -1]),
        flank=tooth[:, -1].copy(),
        flank_arc=flank_arc,
        flank_normal=flank_normal,
        base_radius=r_b,
        form_arc=form_arc,
        tip_arc=tip_arc,
        filling=np.where(web_elements, gear.web_ratio, 1.0),
        web=web_elements,
        slit=on_slit,
        slit_first=len(points),
    )


def _slit_line(radius: float, angle: float, slit: Slit, size: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Line through a slit to the middle of the other fillet, from there to the loaded side, fine at mouth and tip.

    Returns points (n, 2), their coordinate across the tooth in [-1, 1] (n,), and whether they are on the slit before
    its tip (n,).
    """
    mouth = radius * np.array([math.cos(angle), math.sin(angle)])
    end = mouth - slit.depth * np.array([math.cos(slit.angle), math.sin(slit.angle)])
    other = mouth * (1.0, -1.0)
    rest = float(np.hypot(*(other - end)))
    tip, largest = min(0.04 * size, slit.depth / 8), 0.3 * size
    half = slit.depth / 2
    on_slit = np.concatenate(
        [_growing(tip, 1.25, largest, half), slit.depth - _growing(min(0.05 * size, half), 1.25, largest, half)[-2::-1]]
    )  # distance from the tip
    if slit.spacing is not None:
        tip = slit.spacing
        on_slit = np.linspace(0.0, slit.depth, _count(slit.depth, tip))
    ends = with_middles(np.concatenate([-_growing(tip, 1.25, largest, rest)[:0:-1], on_slit]))
    ahead = np.clip(ends, 0.0, None)[:, None] / slit.depth
    behind = np.clip(-ends, 0.0, None)[:, None] / rest
    line = end + ahead * (mouth - end) + behind * (other - end)
    return line, line[:, 1] / mouth[1], ends > 1e-9 * slit.depth


def _stretched(r: np.ndarray, t: np.ndarray, line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tooth grid (row, column) in polar coordinates, first row moved onto `line`, others less towards the tip."""
    points = np.stack([r * np.cos(t), r * np.sin(t)], axis=-1)
    share = (r[-1, 0] - r[:, 0]) / (r[-1, 0] - r[0, 0])
    points = points + share[:, None, None] * (line - points[0])
    return np.hypot(points[..., 0], points[..., 1]), np.arctan2(points[..., 1], points[..., 0])


def _count(length: float, size: float) -> int:
    """Number of element ends that divide `length` into elements of at most `size` (at least 3 elements)."""
    return max(3, math.ceil(length / size)) + 1


def _fillet_normal(fillet: _Fillet, arc: np.ndarray) -> np.ndarray:
    """Unit normal out of the tooth (x, y) on the fillet of the loaded side."""
    rise, around = fillet.radius(arc, 1), fillet.radius(arc) * fillet.angle(arc, 1)
    along, angle = np.column_stack([rise, around]) / np.hypot(rise, around)[:, None], fillet.angle(arc)
    radial = np.column_stack([np.cos(angle), np.sin(angle)])
    around = np.column_stack([-np.sin(angle), np.cos(angle)])
    return -along[:, 1:] * radial + along[:, :1] * around
