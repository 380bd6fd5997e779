"""Involute geometry: published data, the generating rack as judge, brute-force tip-edge contact, line length."""

import math

import numpy as np
import pytest

from benchmarks.gear_pairs import gear_pair, kisssoft_helical, kisssoft_spur, line_length, pair_of_17_and_43
from fem.gears.gear import Gear
from fem.gears.gear_checks import GeometryError
from fem.gears.geometry import GearPair, sum_of_shifts
from fem.gears.path import LARGEST_GAP, contact_window, path_points, slice_fraction
from fem.gears.profile import flank_at_roll, form_radius, half_tooth_profile, roll_length
from fem.gears.rack import Rack


def one_gear(teeth=20, shift=0.0, helix_deg=0.0, **changes):
    data = {
        "teeth": teeth,
        "normal_module": 2e-3,
        "helix_angle": math.radians(helix_deg),
        "face_width": 12e-3,
        "profile_shift": shift,
        "bore_radius": 2e-3,
    }
    return Gear(**(data | changes))


# published and independently computed geometry


def test_diameters_of_a_published_pair():
    pair = kisssoft_helical()
    for gear, published in ((pair.pinion, (320.026, 380.747, 319.623)), (pair.wheel, (1266.770, 1395.376, 1334.252))):
        found = [2000 * radius for radius in (gear.base_radius, gear.tip_radius, gear.root_radius)]
        assert found == pytest.approx(published, abs=1e-3)
    assert pair.transverse_contact_ratio == pytest.approx(1.463, rel=1e-3)
    assert pair.overlap_ratio == pytest.approx(1.421, rel=1e-3)


def test_contact_ratio_of_a_published_spur_pair():
    assert kisssoft_spur().transverse_contact_ratio == pytest.approx(1.370, rel=1e-3)


@pytest.mark.parametrize(
    ("helix", "eps_alpha", "eps_beta"), [(0, 1.6638, 0.0), (12, 1.6140, 0.9927), (15, 1.5863, 1.2358)]
)
def test_contact_ratios(helix, eps_alpha, eps_beta):
    pair = gear_pair((20, 55), 2, helix, 30)
    assert pair.transverse_contact_ratio == pytest.approx(eps_alpha, abs=5e-5)
    assert pair.overlap_ratio == pytest.approx(eps_beta, abs=5e-5)


def test_contact_ratios_at_a_given_centre_distance():
    pair = pair_of_17_and_43()
    assert pair.transverse_contact_ratio == pytest.approx(1.491879, rel=1e-6)
    assert pair.overlap_ratio == pytest.approx(1.08868, rel=1e-5)


def test_backlash_is_what_the_centre_distance_leaves():
    tight = gear_pair((20, 55), 2, 12, 12, (0.3, -0.1))
    assert tight.backlash == pytest.approx(0.0, abs=1e-12)
    assert sum(tight.working_thicknesses) == pytest.approx(tight.working_pitch, rel=1e-12)
    wider = gear_pair((20, 55), 2, 12, 12, (0.3, -0.1), centre_mm=1000 * tight.centre_distance + 0.1)
    assert wider.backlash == pytest.approx(2 * 1e-4 * math.sin(wider.working_pressure_angle), rel=0.01)
    teeth, module, angles = 75, 2e-3, (math.radians(12), math.radians(20))
    assert sum_of_shifts(teeth, module, *angles, tight.axis_distance) == pytest.approx(0.2, abs=1e-9)
    with pytest.raises(GeometryError, match="sum of the base radii"):
        sum_of_shifts(teeth, module, *angles, 0.9 * tight.axis_distance)
    with_allowance = gear_pair((20, 55), 2, 12, 12, (0.3, -0.1), backlash_allowance=60e-6)
    assert with_allowance.backlash == pytest.approx(60e-6, rel=1e-9)


# the profile


@pytest.mark.parametrize(
    ("teeth", "shift", "helix"),
    [(20, 0.0, 0), (55, 0.0, 12), (21, 0.5, 25), (10, 0.0, 0), (14, 0.0, 15), (60, 1.2, 10)],
)
def test_the_generating_rack_touches_the_profile_and_never_cuts_it(teeth, shift, helix):
    """Roll the tool over the gear: the deepest cut into the finished profile is zero, and every point gets touched."""
    gear = one_gear(teeth, shift, helix)
    points = half_tooth_profile(gear, 60, 60, 3)[:121]
    m, alpha, rho = gear.normal_module, gear.rack.pressure_angle, gear.rack.tip_radius * gear.normal_module
    tip_depth = (gear.rack.dedendum - shift) * m
    centre_depth = tip_depth - rho
    clearance = np.full(len(points), np.inf)
    for turn in np.linspace(-2.8, 2.8, 9001) * 2.0 * math.pi / gear.teeth:
        # the tooth space is centred at +pi/z (x > 0); turn the gear so that it meets the tool's tooth
        angle = turn + math.pi / gear.teeth
        x = points[:, 0] * math.cos(angle) - points[:, 1] * math.sin(angle)
        depth = gear.reference_radius - (points[:, 0] * math.sin(angle) + points[:, 1] * math.cos(angle))
        along = (x + gear.reference_radius * turn) * math.cos(gear.helix_angle)  # normal section
        flank = math.pi * m / 4 - (depth + shift * m) * math.tan(alpha) - np.abs(along)
        in_tip = np.hypot(np.maximum(np.abs(along) - gear.rack.tip_land * m, 0.0), depth - centre_depth)
        rounded = np.where(depth > centre_depth + rho * math.sin(alpha), rho - in_tip, flank * math.cos(alpha))
        clearance = np.minimum(clearance, np.where(depth > tip_depth, depth - tip_depth, -rounded))
    assert clearance.min() > -1e-7 * m
    assert clearance.max() < 3e-4 * m


def test_profile_is_ordered_and_smooth_where_fillet_meets_involute():
    gear = one_gear(24, 0.2, 12)
    tooth = half_tooth_profile(gear, 40, 30, 4)
    radius = np.hypot(*tooth.T)
    assert tooth.shape == (75, 2)
    assert (np.diff(radius) > -1e-15).all()
    assert radius[0] == pytest.approx(gear.root_radius, rel=1e-12)
    assert radius[40] == pytest.approx(form_radius(gear), rel=1e-12)
    assert radius[70] == pytest.approx(gear.tip_radius, rel=1e-12)
    assert tooth[-1] == pytest.approx([0.0, gear.tip_radius], abs=1e-15)
    assert math.atan2(*tooth[0]) == pytest.approx(math.pi / gear.teeth, rel=1e-12)
    chord = np.diff(tooth, axis=0)
    heading = np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
    assert abs(heading[40] - heading[39]) < 0.1
    assert abs(heading[0] - (math.pi - math.pi / gear.teeth)) < 0.02  # leaves the root circle along it


def test_flank_normal_is_tangent_to_the_base_circle():
    gear = one_gear(31, 0.1, 15)
    roll = np.linspace(roll_length(gear, form_radius(gear)), roll_length(gear, gear.tip_radius), 7)
    point, radius, normal = flank_at_roll(gear, roll)
    lever = point[:, 0] * normal[:, 1] - point[:, 1] * normal[:, 0]
    assert np.abs(lever) == pytest.approx(np.full(7, gear.base_radius), rel=1e-12)
    assert np.linalg.norm(normal, axis=1) == pytest.approx(np.ones(7))
    thickness = [gear.tooth_thickness(r) for r in radius]
    assert 2 * radius * np.arctan2(*point.T) == pytest.approx(thickness, rel=1e-12)


def test_undercut_is_found_at_the_textbook_tooth_number():
    assert one_gear(17).undercut  # 2 / sin^2(20 deg) = 17.097
    assert not one_gear(18).undercut
    assert not one_gear(14, (17.097 - 14) / 17.097 + 1e-3).undercut
    assert form_radius(one_gear(10)) > one_gear(10).base_radius


# refused input


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"bore_radius": 17.6e-3}, "root circle"),
        ({"profile_shift": 1.9}, "pointed"),
    ],
)
def test_impossible_gears_are_refused(changes, message):
    with pytest.raises(GeometryError, match=message):
        one_gear(**changes)


def test_a_rack_tip_too_round_is_refused():
    with pytest.raises(GeometryError, match=r"at most 0\.4719"):
        Rack(tip_radius=0.6)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"centre_mm": 74.0}, "jam"),
        ({"centre_mm": 78.0}, "contact ratio"),
        ({"centre_mm": 70.0}, "sum of the base radii"),
        ({"tip_mm": 0.4}, "interference"),
        ({"tip_mm": 0.6, "shifts": (0.2, 0.2)}, "root circle"),
    ],
)
def test_impossible_pairs_are_refused(arguments, message):
    with pytest.raises(GeometryError, match=message):
        gear_pair((20, 55), 2, 0, 12, **arguments)


def test_equal_hands_are_refused():
    with pytest.raises(GeometryError, match="one must be right-handed and the other left-handed"):
        GearPair(pinion=one_gear(20, helix_deg=12), wheel=one_gear(55, helix_deg=12))


# tip-edge contact


def brute_force_gap(pair, xi):
    """Turn the wheel against the load until one sampled outline meets the other; only points and rotations are used."""
    outlines = []
    for gear in (pair.pinion, pair.wheel):
        points = half_tooth_profile(gear, 300, 3000, 300) * [-1.0, 1.0]  # the flank ahead of the tooth centre
        outlines.append((points[:, 0] + 1j * points[:, 1]) * -1j)  # tooth centre on the real axis
    r1, r2 = pair.working_radii
    turn1 = 2 * math.pi * xi / pair.pinion.teeth - pair.pinion.half_thickness_angle(r1)
    turn2 = math.pi - 2 * math.pi * xi / pair.wheel.teeth - pair.wheel.half_thickness_angle(r2)
    pinion = outlines[0] * np.exp(1j * turn1) - pair.axis_distance  # seen from the wheel's centre
    wheel = outlines[1] * np.exp(1j * turn2)
    radius1, angle1 = np.abs(pinion), np.angle(pinion) % (2 * math.pi)
    radius2, angle2 = np.abs(wheel), np.angle(wheel) % (2 * math.pi)
    crossing = np.flatnonzero((radius1[:-1] - pair.wheel.tip_radius) * (radius1[1:] - pair.wheel.tip_radius) < 0)
    part = (pair.wheel.tip_radius - radius1[crossing]) / (radius1[crossing + 1] - radius1[crossing])
    at_tip = angle1[crossing] + part * (angle1[crossing + 1] - angle1[crossing])
    flank = slice(0, 3301)  # the wheel's radius rises along it
    inside = (radius1 < pair.wheel.tip_radius) & (radius1 > pair.wheel.root_radius * 1.0001)
    play = np.concatenate(
        [angle1[inside] - np.interp(radius1[inside], radius2[flank], angle2[flank]), at_tip - angle2[3300]]
    )
    return pair.wheel.base_radius * play.min()


@pytest.mark.parametrize(
    "pair", [gear_pair((20, 55), 2, 12, 12), gear_pair((24, 31), 3, 0, 20, (0.3, 0.1), bores_mm=(9, 9))]
)
def test_tip_edge_gap_against_brute_force(pair):
    xi = np.concatenate([pair.xi_start - np.linspace(0.02, 0.2, 4), pair.xi_end + np.linspace(0.02, 0.25, 4)])
    found = path_points(pair, xi, 1e-3).gap
    assert found == pytest.approx([brute_force_gap(pair, x) for x in xi], abs=5e-9, rel=1e-4)


def test_on_the_path_there_is_no_gap():
    pair = gear_pair((20, 55), 2, 12, 12)
    inside = np.linspace(pair.xi_start, pair.xi_end, 9)
    assert (path_points(pair, inside).gap == 0.0).all()
    assert brute_force_gap(pair, 0.3) == pytest.approx(0.0, abs=1e-8)


def test_the_contact_window_ends_at_the_largest_gap():
    pair = gear_pair((20, 55), 2, 12, 12)
    first, last = contact_window(pair)
    nearly = path_points(pair, np.array([first + 1e-9, last - 1e-9])).gap
    assert nearly == pytest.approx([LARGEST_GAP, LARGEST_GAP], rel=1e-5)
    assert np.isinf(path_points(pair, np.array([first - 1e-6, last + 1e-6])).gap).all()


def test_the_contact_window_encloses_a_path_that_begins_beyond_the_pitch_point():
    """At a large centre distance the tip of the wheel does not reach the pitch point."""
    pair = gear_pair((21, 73), 2.5, 12, 32, centre_mm=123.9)
    assert pair.xi_start > 0.0
    first, last = contact_window(pair)
    assert first < pair.xi_start < pair.xi_end < last


def test_relative_curvature_at_the_pitch_point():
    pair = gear_pair((20, 55), 2, 12, 12)
    r1, r2 = (r * math.sin(pair.working_pressure_angle) for r in pair.working_radii)
    assert path_points(pair, np.array([0.0])).relative_radius[0] == pytest.approx(r1 * r2 / (r1 + r2), rel=1e-12)


# contact line length


@pytest.mark.parametrize(("helix", "face"), [(12, 12), (12, 30), (15, 30), (0, 12), (20, 60)])
def test_mean_line_length(helix, face):
    pair = gear_pair((20, 55), 2, helix, face)
    mean = line_length(pair, (np.arange(20000) + 0.5) / 20000).mean()
    assert mean == pytest.approx(
        pair.transverse_contact_ratio * face / 1000 / math.cos(pair.base_helix_angle), rel=1e-4
    )


@pytest.mark.parametrize(("helix", "face"), [(12, 12), (15, 30), (20, 60)])
def test_line_length_without_a_tooth(helix, face):
    """While its full line would be in mesh the loss is 1 / max(eps_alpha, eps_beta) of the mean; it lasts eps_gamma."""
    pair = gear_pair((20, 55), 2, helix, face)
    eps_alpha, eps_beta = pair.transverse_contact_ratio, pair.overlap_ratio
    mean = eps_alpha * pair.face_width / math.cos(pair.base_helix_angle)
    middle, half = (pair.xi_start + pair.xi_end) / 2, abs(eps_alpha - eps_beta) / 2
    full = np.linspace(middle - 0.999 * half, middle + 0.999 * half, 41)
    loss = (line_length(pair, full) - line_length(pair, full, missing=True)) / mean
    assert loss == pytest.approx(np.full(41, 1 / max(eps_alpha, eps_beta)), rel=1e-6)
    reach = pair.total_contact_ratio / 2
    edge = middle + reach * np.array([-1 - 1e-7, -1 + 1e-5, 1 - 1e-5, 1 + 1e-7])
    lost = line_length(pair, edge) - line_length(pair, edge, missing=True)
    assert (lost[[0, 3]] == 0.0).all()
    assert (lost[[1, 2]] > 0.0).all()


def test_integer_overlap_has_a_constant_line_and_a_known_floor():
    base = gear_pair((20, 55), 2, 12, 12)
    face = base.base_pitch / math.tan(base.base_helix_angle) * 1000
    pair = gear_pair((20, 55), 2, 12, face)
    eps_alpha = pair.transverse_contact_ratio
    cycle = np.linspace(-2, 2, 1601)
    mean = eps_alpha * pair.face_width / math.cos(pair.base_helix_angle)
    assert line_length(pair, cycle) / mean == pytest.approx(np.ones(1601), rel=1e-6)
    floor = (line_length(pair, cycle, missing=True) / mean).min()
    assert floor == pytest.approx((eps_alpha - 1) / eps_alpha, rel=1e-6)


def test_slice_fractions_add_up_to_the_line():
    pair = gear_pair((20, 55), 2, 12, 12)
    n, cycle = 15, np.linspace(0.0, 1.0, 37)
    face = ((np.arange(n) + 0.5) / n - 0.5) * pair.overlap_ratio
    positions = cycle[:, None, None] + face[None, :, None] - np.arange(-4, 5)
    part = slice_fraction(positions, pair.xi_start, pair.xi_end, pair.overlap_ratio / n).sum(axis=(1, 2)) / n
    length = part * pair.face_width / math.cos(pair.base_helix_angle)
    assert length == pytest.approx(line_length(pair, cycle), rel=1e-12)
