"""Path of contact of one tooth pair: tip-edge gap beyond its ends, contact radii, curvature, contact line length.

Transverse section, pinion centre at the origin, wheel centre on +x at the centre distance, pinion turning counter-
clockwise. The line of action touches the base circles at T1, T2 and has the direction n = (sin alpha_wt, cos alpha_wt).
With the roll lengths L1 = r_b1 tan alpha_wt + xi p_bt and L2 = r_b2 tan alpha_wt - xi p_bt the flanks in mesh have the
polar angles (about their own centres, at radius R)

    theta1(R) = -alpha_wt + L1 / r_b1 - inv alpha_1(R),     theta2(R) = pi - alpha_wt + L2 / r_b2 - inv alpha_2(R)

which holds for every xi, also beyond the ends of the involutes. There the tip edge of one gear meets the flank of the
other; the gap is r_b2 times the rotation of the wheel, against the load, until they touch. If undercut has removed the
root of a flank before the tip of the mate reaches it, the path ends at the form circle. The edge between fillet and
involute then meets the flank of the mate in the same way, up to its tip, followed by contact of the tip edge.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from fem.gears.gear_checks import GeometryError, require
from fem.gears.geometry import GearPair
from fem.numerics.root_finding import brentq

LARGEST_GAP = 100e-6  # m, default largest gap for tip-edge contact
BRIDGE = 2.05  # pitches: span with which contact passes from the pair before a missing tooth to that after it
LARGEST_RAISED = 0.4  # m_n, of `bridging_window`
FARTHEST = 4.0  # pitches beyond the path of contact; a pair with 2000 teeth and a gap of 0.05 m_n needs 3.5


@dataclass(frozen=True, eq=False, kw_only=True)
class PathPoints:
    """Gap, contact radii and curvature of one tooth pair at the positions xi (n,).

    gap (n,) m along the transverse line of action, 0 on the path, inf where no contact is possible;
    pinion_radius, wheel_radius (n,) m of the contact point on each flank (tip radius for the gear whose edge touches);
    relative_radius (n,) m, transverse radius of relative curvature, constant beyond the ends.
    """

    xi: np.ndarray
    gap: np.ndarray
    pinion_radius: np.ndarray
    wheel_radius: np.ndarray
    relative_radius: np.ndarray


def path_points(
    pair: GearPair, xi: np.ndarray, largest_gap: float = LARGEST_GAP, tips: tuple[float, float] | None = None
) -> PathPoints:
    """Gap, contact radii and curvature at positions on the path of contact.

    Parameters
    ----------
    pair : the gears in mesh
    xi : (n,) positions, base pitches from the pitch point
    largest_gap : m, largest gap for tip-edge contact
    tips : m, other radii (pinion, wheel) of the edges at which the flanks end, as on a chipped tooth; or None
    """
    xi = np.atleast_1d(np.asarray(xi, dtype=float))
    if tips is not None:
        return _shortened(pair, xi, largest_gap, tips)
    l1, l2 = pair.roll_lengths(np.clip(xi, pair.xi_start, pair.xi_end))
    gap = np.zeros_like(xi)
    r1, r2 = np.hypot(pair.pinion.base_radius, l1), np.hypot(pair.wheel.base_radius, l2)
    before, after = xi < pair.xi_start, xi > pair.xi_end
    gap[after], r1[after], r2[after] = _beyond(pair, xi[after], 0)
    gap[before], r1[before], r2[before] = _beyond(pair, xi[before], 1)
    first, last = contact_window(pair, largest_gap)
    gap[(xi < first) | (xi > last)] = np.inf
    return PathPoints(xi=xi, gap=gap, pinion_radius=r1, wheel_radius=r2, relative_radius=l1 * l2 / (l1 + l2))


def contact_window(pair: GearPair, largest_gap: float = LARGEST_GAP) -> tuple[float, float]:
    """Positions (xi_first, xi_last) where the tip-edge gap reaches `largest_gap` (m, > 0) or the edge passes the tip.

    Raises
    ------
    GeometryError : neither occurs within FARTHEST pitches
    """
    require(largest_gap > 0.0, f"{pair.label}: largest_gap is {largest_gap!r} m; give a value > 0")

    def excess(xi: float, own: int) -> float:
        gap, r1, r2 = _beyond(pair, np.array([xi]), own)
        p, w = pair.pinion, pair.wheel
        touching = r1[0] <= p.tip_form_radius * (1 + 1e-12) and r2[0] <= w.tip_form_radius * (1 + 1e-12)
        return float(gap[0]) - largest_gap if touching else 1.0  # past the tip: no flank

    ends = []
    for own, end, sign in ((1, pair.xi_start, -1.0), (0, pair.xi_end, 1.0)):
        inside, outside = end, end + 0.02 * sign
        while excess(outside, own) < 0.0:
            inside, outside = outside, outside + 0.02 * sign
            if abs(outside - end) > FARTHEST:
                raise GeometryError(
                    f"{pair.label}: the tip-edge gap does not reach {largest_gap:.3g} m within {FARTHEST:g} pitches "
                    "beyond the path of contact. Reduce the number of teeth"
                )
        ends.append(brentq(partial(excess, own=own), inside, outside, xtol=1e-14))
    return ends[0], ends[1]


def bridging_window(pair: GearPair, largest_gap: float) -> tuple[float, float, float]:
    """`largest_gap` (m), raised where necessary, and its `contact_window`.

    If the window spans less than BRIDGE, the gap is raised, to LARGEST_RAISED or just above, so that the pairs next to
    a missing tooth still have tip-edge contact.
    """
    first, last = contact_window(pair, largest_gap)
    while last - first < BRIDGE and largest_gap < LARGEST_RAISED * pair.pinion.normal_module:
        largest_gap *= 1.25
        first, last = contact_window(pair, largest_gap)
    return largest_gap, first, last


def _beyond(pair: GearPair, xi: np.ndarray, own: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gap and radii on pinion and wheel (m) at contact of the tip edge of `own`, or of the undercut edge of its mate.

    The tip edge of the pinion (0) is in contact beyond xi_end, that of the wheel (1) before xi_start.
    """
    gears, edges, mate = (pair.pinion, pair.wheel), (_pinion_edge, _wheel_edge), 1 - own
    tip = gears[own].tip_form_radius
    radii = np.full((2, *xi.shape), tip)
    gap, radii[mate] = edges[own](pair, xi, tip)
    if pair.shortened_by_undercut[mate]:
        form = math.hypot(gears[mate].base_radius, pair.form_rolls[mate])
        foot_gap, foot_radius = edges[mate](pair, xi, form)
        foot = foot_radius < tip
        gap = np.where(foot, foot_gap, gap)
        radii[own, foot], radii[mate, foot] = foot_radius[foot], form
    return gap, radii[0], radii[1]


def edge_gap(pair: GearPair, gear: str, xi: np.ndarray, radius: np.ndarray | float) -> np.ndarray:
    """Gap (m) along the transverse line of action between points of a flank and the flank of the mate.

    The result is exact for any point, in contact or far from it. Near the contact it is s^2 / (2 rho), with the
    distance s along the flank and the radius rho of relative curvature.

    Parameters
    ----------
    pair, gear : "pinion" or "wheel", gear of the points
    xi : positions of the tooth pair, base pitches from the pitch point
    radius : of the points, m; broadcasts with xi; the gap is inf where the mate has no flank
    """
    edge, mate = (_pinion_edge, pair.wheel) if gear == "pinion" else (_wheel_edge, pair.pinion)
    places, points = np.broadcast_arrays(np.asarray(xi, dtype=float), radius)
    gap, reached = edge(pair, places, points)
    return np.where(reached <= mate.tip_form_radius, gap, np.inf)


def tip_position(pair: GearPair, gear: str, radius: float) -> float:
    """Position xi where the point at `radius` of the "pinion" or "wheel" flank is in contact."""
    own, sign = (pair.pinion, 1.0) if gear == "pinion" else (pair.wheel, -1.0)
    roll = math.sqrt(max(radius**2 - own.base_radius**2, 0.0)) - own.base_radius * math.tan(pair.working_pressure_angle)
    return sign * roll / pair.base_pitch


def _shortened(pair: GearPair, xi: np.ndarray, largest_gap: float, tips: tuple[float, float]) -> PathPoints:
    """`path_points` for flanks that end at the radii `tips`, not above the tip form circles.

    A flank shortened to inside its base circle, or to before the start of the path, has no contact.
    """
    radii = tuple(min(r, g.tip_form_radius) for r, g in zip(tips, (pair.pinion, pair.wheel), strict=True))
    start = max(tip_position(pair, "wheel", radii[1]), pair.xi_start)
    end = min(tip_position(pair, "pinion", radii[0]), pair.xi_end)
    l1, l2 = pair.roll_lengths(np.clip(xi, pair.xi_start, pair.xi_end))
    r1, r2 = np.hypot(pair.pinion.base_radius, l1), np.hypot(pair.wheel.base_radius, l2)
    gap = np.zeros_like(xi)
    before, after = xi < start, xi > end
    if end < pair.xi_end or not pair.shortened_by_undercut[1]:
        gap[after], r2[after] = _pinion_edge(pair, xi[after], radii[0])
    else:
        gap[after], r1[after], r2[after] = _beyond(pair, xi[after], 0)
    if start > pair.xi_start or not pair.shortened_by_undercut[0]:
        gap[before], r1[before] = _wheel_edge(pair, xi[before], radii[1])
    else:
        gap[before], r1[before], r2[before] = _beyond(pair, xi[before], 1)
    gap[(before | after) & ((gap > largest_gap) | ~np.isfinite(gap))] = np.inf
    gap[after & (r2 > pair.wheel.tip_form_radius) | before & (r1 > pair.pinion.tip_form_radius)] = np.inf
    if start >= end or radii[0] <= pair.pinion.base_radius or radii[1] <= pair.wheel.base_radius:
        gap[:] = np.inf
    return PathPoints(xi=xi, gap=gap, pinion_radius=r1, wheel_radius=r2, relative_radius=l1 * l2 / (l1 + l2))


def _inv_at(radius: np.ndarray, base_radius: float) -> np.ndarray:
    """Involute function of the pressure angle at `radius`; 0 inside the base circle."""
    roll = np.sqrt(np.maximum(radius**2 - base_radius**2, 0.0)) / base_radius
    return roll - np.arctan(roll)


def _pinion_edge(pair: GearPair, xi: np.ndarray, tip: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
    """Gap (m) of the pinion tip corner to the wheel flank beyond xi_end, and the wheel radius (m) there."""
    p, w, alpha = pair.pinion, pair.wheel, pair.working_pressure_angle
    l1, l2 = pair.roll_lengths(xi)
    corner_angle = -alpha + l1 / p.base_radius - _inv_at(np.array(tip), p.base_radius)
    x = tip * np.cos(corner_angle) - pair.axis_distance
    y = tip * np.sin(corner_angle)
    radius = np.hypot(x, y)
    flank_angle = math.pi - alpha + l2 / w.base_radius - _inv_at(radius, w.base_radius)
    roll_angle = np.arctan2(y, x) - flank_angle
    return w.base_radius * (roll_angle - 2.0 * math.pi * np.round(roll_angle / (2.0 * math.pi))), radius


def _wheel_edge(pair: GearPair, xi: np.ndarray, tip: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
    """Gap (m) of the wheel tip corner to the pinion flank before xi_start, and the pinion radius (m) there."""
    p, w, alpha = pair.pinion, pair.wheel, pair.working_pressure_angle
    l1, l2 = pair.roll_lengths(xi)
    corner_angle = math.pi - alpha + l2 / w.base_radius - _inv_at(np.array(tip), w.base_radius)
    gap = np.zeros_like(xi)
    for _ in range(60):  # each iteration reduces the error by a factor of order gap / radius
        x = pair.axis_distance + tip * np.cos(corner_angle + gap / w.base_radius)
        y = tip * np.sin(corner_angle + gap / w.base_radius)
        radius = np.hypot(x, y)
        rest = p.base_radius * (np.arctan2(y, x) - (-alpha + l1 / p.base_radius - _inv_at(radius, p.base_radius)))
        gap = gap + rest
        if not np.any(np.abs(rest) > 1e-15):
            break
    return gap, radius


def slice_fraction(xi: np.ndarray, start: float, end: float, ramp: float) -> np.ndarray:
    """Share of a slice in contact, in [0, 1]: the slice covers xi - ramp/2 .. xi + ramp/2, the path start .. end.

    Parameters
    ----------
    xi : positions of any shape, base pitches
    start, end : of the path of contact, base pitches
    ramp : slice width * tan(beta_b) / p_bt, base pitches; 0 gives the box of a spur gear
    """
    xi = np.asarray(xi, dtype=float)
    if ramp == 0.0:
        return ((xi >= start) & (xi <= end)).astype(float)
    covered = np.minimum(xi + ramp / 2, end) - np.maximum(xi - ramp / 2, start)
    return np.clip(covered / ramp, 0.0, 1.0)
