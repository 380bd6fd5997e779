"""Transverse tooth profile: root circle, generated trochoid, involute, tip circle.

The fillet is the envelope of the rounded tip of the generating rack (equation of meshing: the common normal passes
through the pitch point of generation), in the transverse section, where the tool rounding of a helical gear is an
ellipse. In the gear frame the tooth centre line is on +y, and the returned flank at x > 0.

Litvin & Fuentes (2004), Gear Geometry and Applied Theory, 2nd ed., chapter 6; ISO 21771:2007.
"""

from __future__ import annotations

import math

import numpy as np

from fem.gears.gear import Gear
from fem.gears.gear_checks import require
from fem.numerics.root_finding import brentq

_FINE = 400  # points on the fillet for its arc length


def generate_trochoid(gear: Gear, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fillet points cut by the tool rounding at its normal angle theta (normal section, rad).

    theta runs from alpha_n (junction with the straight tool flank) to pi/2 (tool tip, root circle).

    Returns
    -------
    radius (n,) m and angle (n,) rad measured from the tooth centre line
    """
    m, rack, r = gear.normal_module, gear.rack, gear.reference_radius
    theta = np.asarray(theta, dtype=float)
    rho = rack.tip_radius * m
    depth = (rack.dedendum - gear.generating_shift) * m - rho + rho * np.sin(theta)  # below the reference circle
    along = (rack.tip_land * m + rho * np.cos(theta)) / math.cos(gear.helix_angle)  # from the tool's centre line
    # transverse normal of the tool is (cos theta, sin theta / cos beta); it passes through the pitch point
    x = depth * np.cos(theta) * math.cos(gear.helix_angle) / np.sin(theta)
    y = r - depth
    roll = (x - along) / r  # gear rotation when this tool point cuts
    angle_from_space = np.arctan2(x, y) - roll
    return np.hypot(x, y), math.pi / gear.teeth - angle_from_space


def form_point(gear: Gear) -> tuple[float, float]:
    """Form point, the junction of fillet and involute: (radius m, tool angle theta rad).

    Without undercut the end of the straight tool flank generates it (theta = alpha_n, smooth). With undercut it is the
    intersection of trochoid and involute above the base circle (a corner).

    Raises
    ------
    GeometryError : the fillet leaves no involute below the tip circle
    """
    junction = gear.rack.pressure_angle
    if gear.undercut:
        # the trochoid starts outside the tooth, on the mirror branch of the involute, and crosses it above r_b
        at_base = brentq(lambda t: _trochoid_radius(gear, t) - gear.base_radius, junction, math.pi / 2, xtol=1e-15)
        if _outside_involute(gear, at_base) < 0.0:
            junction = brentq(lambda t: _outside_involute(gear, t), junction, at_base, xtol=1e-15)
        else:
            junction = at_base
    radius = max(_trochoid_radius(gear, junction), gear.base_radius)
    require(
        radius < gear.tip_form_radius,
        f"gear z={gear.teeth}: no involute is left. The fillet ends at the diameter {2000 * radius:.6g} mm, the tip "
        f"form circle is {2000 * gear.tip_form_radius:.6g} mm. Raise the profile shift, or reduce rack_dedendum",
    )
    return radius, junction


def _trochoid_radius(gear: Gear, theta: float) -> float:
    return float(generate_trochoid(gear, np.array([theta]))[0][0])


def _outside_involute(gear: Gear, theta: float) -> float:
    """Angle (rad) of the trochoid outside the involute flank at equal radius; < 0 where it cuts into it."""
    radius, angle = generate_trochoid(gear, np.array([theta]))
    return float(angle[0]) - gear.half_thickness_angle(max(float(radius[0]), gear.base_radius))


def form_radius(gear: Gear) -> float:
    """Form radius, where fillet and involute join (m)."""
    return form_point(gear)[0]


def flank_at_roll(gear: Gear, roll_length: float | np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Involute flank (x > 0 side) at the roll length L, the distance from the base tangent point to the contact point.

    In a pair the pinion has L = r_b1 tan(alpha_wt) + xi p_bt, the wheel r_b2 tan(alpha_wt) - xi p_bt.

    Parameters
    ----------
    roll_length : (n,) m, >= 0; radius = sqrt(r_b^2 + L^2)

    Returns
    -------
    point (n, 2) m, radius (n,) m, normal (n, 2): unit vector out of the tooth
    """
    roll = np.atleast_1d(np.asarray(roll_length, dtype=float))
    require(
        bool((roll >= 0.0).all()),
        f"gear z={gear.teeth}: roll length {1000 * roll.min():.6g} mm is below 0, where there is no involute",
    )
    r_b = gear.base_radius
    radius = np.hypot(r_b, roll)
    alpha = np.arctan2(roll, r_b)
    at_base = gear.reference_thickness / (2.0 * gear.reference_radius) + math.tan(gear.transverse_pressure_angle)
    angle = at_base - gear.transverse_pressure_angle - (roll / r_b - alpha)
    point = np.column_stack([radius * np.sin(angle), radius * np.cos(angle)])
    # outward normal: sin(alpha) along the radius, cos(alpha) along the circle
    normal = np.column_stack([np.cos(alpha - angle), np.sin(alpha - angle)])
    return point, radius, normal


def roll_length(gear: Gear, radius: float) -> float:
    """L = sqrt(r^2 - r_b^2), the roll length of the flank point at `radius` >= r_b (m)."""
    return gear.base_radius * math.tan(gear.pressure_angle_at(radius))


def half_tooth_profile(gear: Gear, n_fillet: int, n_flank: int, n_tip: int) -> np.ndarray:
    """Ordered transverse points of half a pitch, n_fillet + n_flank + n_tip intervals.

    Root arc and trochoid are divided uniformly by arc length, the involute by roll length (hence uniformly along the
    path of contact), the tip arc by angle. Consecutive points never coincide.

    Parameters
    ----------
    gear : the gear
    n_fillet, n_flank, n_tip : intervals of root arc and trochoid, of the involute, of the tip arc; 1 or more

    Returns
    -------
    points (n_fillet + n_flank + n_tip + 1, 2), m: from (r_f sin(pi/z), r_f cos(pi/z)) at mid space to (0, r_a) at mid
        tooth; point n_fillet is between fillet and involute, point n_fillet + n_flank is the tip corner

    Raises
    ------
    GeometryError : a fillet that leaves no involute
    """
    fillet = _fillet_points(gear, n_fillet)
    start, end = roll_length(gear, form_radius(gear)), roll_length(gear, gear.tip_form_radius)
    flank, _, _ = flank_at_roll(gear, np.linspace(start, end, n_flank + 1))
    tip_angle = np.linspace(gear.half_thickness_angle(gear.tip_form_radius), 0.0, n_tip + 1)[1:]
    tip = gear.tip_form_radius * np.column_stack([np.sin(tip_angle), np.cos(tip_angle)])
    return np.vstack([fillet[:-1], flank, tip])


def _fillet_points(gear: Gear, n_fillet: int) -> np.ndarray:
    """Root arc from mid space, then the trochoid up to the form point, uniform in arc length: (n_fillet + 1, 2)."""
    _, junction = form_point(gear)
    theta = np.linspace(math.pi / 2, junction, _FINE)
    radius, angle = generate_trochoid(gear, theta)
    root_angle = np.linspace(math.pi / gear.teeth, angle[0], _FINE // 4)[:-1]
    radius = np.concatenate([np.full(root_angle.size, gear.root_radius), radius])
    angle = np.concatenate([root_angle, angle])
    fine = np.column_stack([radius * np.sin(angle), radius * np.cos(angle)])
    arc = np.arange(root_angle.size) / root_angle.size - 1.0  # -1 at mid space, 0 where the trochoid starts
    parameter = np.concatenate([arc, np.linspace(0.0, 1.0, _FINE)])
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(fine, axis=0).T))])
    wanted = np.interp(np.linspace(0.0, length[-1], n_fillet + 1), length, parameter)
    on_arc = wanted < 0.0
    theta_out = math.pi / 2 + (junction - math.pi / 2) * np.clip(wanted, 0.0, 1.0)
    radius, angle_out = generate_trochoid(gear, theta_out)
    arc_angle = math.pi / gear.teeth + (angle[root_angle.size] - math.pi / gear.teeth) * (wanted + 1.0)
    angle_out = np.where(on_arc, arc_angle, angle_out)
    radius = np.where(on_arc, gear.root_radius, radius)
    return np.column_stack([radius * np.sin(angle_out), radius * np.cos(angle_out)])
