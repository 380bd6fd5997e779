"""Interference of the tip of one gear with the root fillet of the other: path of the tip edge against the trochoid.

Frame and symbols are those of `fem.gears.path`. At the position xi the pinion flank in mesh has, at the radius R, the
polar angle -alpha_wt + L1/r_b1 - (s_b - s(R)). s(R) is its half thickness angle (below the form circle that of the
trochoid), and s_b that of the involute at the base circle. The tip edge of the wheel must keep a positive distance from
it.
"""

from __future__ import annotations

import math

import numpy as np

from fem.gears.gear import Gear
from fem.gears.profile import form_point, generate_trochoid


def root_penetration(own: Gear, tip: Gear, axis_distance: float, working_pressure_angle: float) -> float:
    """Largest depth (m, along the circle) to which the tip of one gear cuts into the root fillet of the other.

    A negative value is the clearance of the tip.

    Parameters
    ----------
    own : gear with the root fillet
    tip : gear with the tip edge
    axis_distance : m
    working_pressure_angle : rad, transverse
    """
    alpha = working_pressure_angle
    radius, junction = form_point(own)
    troch_r, troch_s = generate_trochoid(own, np.linspace(junction, math.pi / 2, 400))
    order = np.argsort(troch_r)
    troch_r, troch_s = troch_r[order], troch_s[order]
    whole = axis_distance * math.sin(alpha)
    first = whole - math.sqrt(tip.tip_form_radius**2 - tip.base_radius**2)  # roll length of its contact
    inv_tip = math.tan(tip.pressure_angle_at(tip.tip_form_radius)) - tip.pressure_angle_at(tip.tip_form_radius)
    roll = np.linspace(first - 2.0 * own.base_pitch, math.sqrt(max(radius**2 - own.base_radius**2, 0.0)), 2000)
    corner = math.pi - alpha + (whole - roll) / tip.base_radius - inv_tip
    x = axis_distance + tip.tip_form_radius * np.cos(corner)
    y = tip.tip_form_radius * np.sin(corner)
    at, place = np.hypot(x, y), np.arctan2(y, x)
    inside = at < radius
    half = np.interp(at, troch_r, troch_s)
    flank = -alpha + roll / own.base_radius - (own.half_thickness_angle(own.base_radius) - half)
    depth = (flank - place) * at
    return float(depth[inside].max()) if inside.any() else -math.inf
