"""Thickness allowances, tips, rims and webs, undercut, working centre distance: geometry and its mesh laws."""

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.gear_pairs import gear_pair
from fem.contact.models.iso import Iso, blank_factor
from fem.contact.wheels import ring
from fem.elements.sections import stiffness
from fem.gears.gear_checks import GeometryError
from fem.gears.geometry import root_penetration
from fem.gears.path import path_points
from fem.gears.profile import form_radius
from fem.gears.sector_mesh import sector_mesh

PAIR = gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5))


def test_thickness_allowances_of_both_gears_give_the_backlash():
    """j_bt = sum |A_sn| / cos(beta) cos(alpha_t), the arcs on the reference circles, here the pitch circles."""
    thin = replace(
        PAIR,
        pinion=replace(PAIR.pinion, thickness_allowance=-40e-6),
        wheel=replace(PAIR.wheel, thickness_allowance=-60e-6),
        centre_distance=None,
    )
    expected = 100e-6 / math.cos(PAIR.pinion.helix_angle) * math.cos(PAIR.working_pressure_angle)
    assert thin.backlash == pytest.approx(expected, rel=1e-6)
    assert thin.axis_distance == pytest.approx(PAIR.axis_distance, rel=1e-12)
    deeper = 40e-6 / (2 * math.tan(PAIR.pinion.rack.pressure_angle))
    assert PAIR.pinion.root_radius - thin.pinion.root_radius == pytest.approx(deeper)
    assert thin.pinion.tip_radius == PAIR.pinion.tip_radius
    assert thin.transverse_contact_ratio == pytest.approx(PAIR.transverse_contact_ratio, rel=1e-12)


def test_centre_distance_and_backlash():
    apart = gear_pair((20, 55), 2, 12, 12, centre_mm=76.80)
    away = 76.80e-3 - PAIR.axis_distance
    assert apart.backlash == pytest.approx(2 * away * math.sin(PAIR.working_pressure_angle), rel=0.02)
    assert apart.transverse_contact_ratio < PAIR.transverse_contact_ratio


def test_chamfer_and_rounding_end_the_path_of_contact():
    chamfered = replace(PAIR, pinion=replace(PAIR.pinion, tip_chamfer=0.2e-3), centre_distance=None)
    form = PAIR.pinion.tip_radius - 0.2e-3
    lost = math.sqrt(PAIR.pinion.tip_radius**2 - PAIR.pinion.base_radius**2) - math.sqrt(
        form**2 - PAIR.pinion.base_radius**2
    )
    assert PAIR.recess_length - chamfered.recess_length == pytest.approx(lost)
    assert chamfered.approach_length == PAIR.approach_length
    rounded = replace(PAIR.pinion, tip_rounding=0.2e-3)
    assert form < rounded.tip_form_radius < PAIR.pinion.tip_radius
    points = path_points(chamfered, np.array([chamfered.xi_end, chamfered.xi_end + 0.05]))
    assert points.gap[0] == 0.0 < points.gap[1]


def test_a_web_takes_the_stiffness_of_its_thickness():
    """A ring pulled round: below the rim every element counts b_s / b, so K is linear in it."""
    gear = PAIR.wheel
    rimmed = replace(gear, rim_thickness=5e-3, web_thickness=3e-3)
    mesh = sector_mesh(rimmed, 0.5)
    inner = np.linalg.norm(mesh.points[mesh.elements[:, 4]], axis=1) < rimmed.rim_inner_radius
    assert set(mesh.filling[inner]) == {0.25}
    assert set(mesh.filling[~inner]) == {1.0}
    assert set(sector_mesh(replace(gear, rim_thickness=5e-3), 0.5).filling) == {1.0}  # by default as wide as the face
    full = stiffness(mesh.points, mesh.elements, 1.0, 0.3)
    webbed = stiffness(mesh.points, mesh.elements, 1.0, 0.3, filling=mesh.filling)
    rim = stiffness(mesh.points, mesh.elements[~inner], 1.0, 0.3)
    assert abs(webbed - (0.25 * full + 0.75 * rim)).max() < 1e-12


def test_thinner_webs_and_rims_are_softer_and_a_full_web_is_none():
    def compliance(gear):
        mesh = sector_mesh(gear, 0.5)
        flank = ring.flank_compliance(mesh, 206e9, 0.3)
        middle = np.array([0.5 * (mesh.form_arc + mesh.tip_arc)])
        weight = flank.patches(middle, 0.1 * gear.normal_module)[0][0]
        return float(weight @ flank.matrix[0] @ weight)

    solid = compliance(PAIR.wheel)
    webs = [
        compliance(replace(PAIR.wheel, rim_thickness=6e-3, web_thickness=width * 12e-3)) for width in (1, 0.5, 0.25)
    ]
    assert webs[0] == pytest.approx(solid, rel=2e-3)
    assert webs[0] < webs[1] < webs[2]
    thin = compliance(replace(PAIR.wheel, rim_thickness=2.4e-3, web_thickness=3e-3))
    assert webs[2] < thin < 5 * solid


def test_iso_takes_the_blank_factor_of_both_gears():
    rim = replace(PAIR, wheel=replace(PAIR.wheel, rim_thickness=6e-3, web_thickness=3e-3), centre_distance=None)
    expected = 0.5 * (1 + blank_factor(0.25, 3.0))
    assert Iso().stiffness(rim).single / Iso().stiffness(PAIR).single == pytest.approx(expected)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"bore_radius": 51.5e-3}, r"1\.2 modules"),
        ({"rim_thickness": 2e-3}, "Raise rim_thickness_mm"),
        ({"rim_thickness": 40e-3}, "there is no web"),
        ({"web_thickness": 4e-3}, "without rim_thickness"),
        ({"rim_thickness": 5e-3, "web_thickness": 4e-3, "web_offset": 5e-3}, "out of the face"),
        ({"rim_thickness": 5e-3, "web_thickness": 0.5e-3}, "face widths"),
        ({"tip_chamfer": 0.1e-3, "tip_rounding": 0.1e-3}, "Delete one"),
        ({"tip_rounding": 1e-3}, "tip land"),
        ({"tip_chamfer": 4e-3}, "leaves the involute up to a diameter of only"),
        ({"thickness_allowance": 2e-3}, "half a module"),
        ({"profile_shift": 1.9}, "pointed"),
        ({"bore_radius": 54e-3}, "reaches the root circle"),
    ],
)
def test_impossible_details_are_refused(changes, message):
    teeth = {"teeth": 14} if "profile_shift" in changes else {}
    bore = {"bore_radius": 8e-3} if teeth else {}
    with pytest.raises(GeometryError, match=message):
        replace(PAIR.wheel, **(teeth | bore | changes))


@pytest.mark.parametrize("teeth", [(12, 12), (12, 30), (12, 250)])
def test_an_undercut_pinion_runs_on_what_is_left_of_its_involute(teeth):
    """z 12, x 0: the mate's tip passes below the involute, clear of the fillet; the path starts at the form circle."""
    pair = gear_pair(teeth, 2, 0, 12, bores_mm=(6.5, 6.5 if teeth[1] == 12 else 20.0))
    assert pair.pinion.undercut
    assert pair.shortened_by_undercut[0]
    assert root_penetration(pair.pinion, pair.wheel, pair.axis_distance, pair.working_pressure_angle) < 0
    start = path_points(pair, np.array([pair.xi_start])).pinion_radius[0]
    assert start == pytest.approx(form_radius(pair.pinion), rel=1e-9)
    xi = np.linspace(pair.xi_start - 0.4, pair.xi_start, 200)
    gap = path_points(pair, xi, 1e-3, (np.inf, np.inf)).gap
    finite = np.isfinite(gap)
    assert (gap[finite] >= -1e-12).all()
    near = gap < 100e-6
    assert np.abs(np.diff(gap[near])).max() < 20e-6  # the tip edge takes over from the undercut edge without a jump


def test_a_tip_that_cuts_into_the_fillet_is_interference():
    long_tips = {"tip_mm": 0.4}
    with pytest.raises(GeometryError, match="into the fillet"):
        gear_pair((20, 55), 2, 0, 12, **long_tips)
