"""Flank modifications and misalignment: amounts where a designer puts them, symmetries, no-load error, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.gear_pairs import gear_pair
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.faults.changed_law import modified_law
from fem.contact.models.iso import Iso
from fem.contact.models.plane import Plane
from fem.contact.slice_frame import law_points
from fem.gears.gear_checks import GeometryError
from fem.gears.geometry import GearPair
from fem.gears.modifications import (
    EndRelief,
    FlankModifications,
    Misalignment,
    PairModifications,
    Relief,
    active_roll,
    check_modifications,
    lead_gap,
    profile_gap,
)
from fem.gears.path import path_points

PAIR = gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5))
SPUR = gear_pair((20, 55), 2, 0, 12, bores_mm=(12.5, 17.5))
FACE = np.linspace(-6e-3, 6e-3, 13)


@pytest.fixture(scope="module")
def laws():
    return Plane(refinement=0.5).laws(PAIR)


def only(gear, **changes):
    return PairModifications(**{gear: FlankModifications(**changes)})


def slope_and_curvature(gear, xi):
    """Path per arc of a flank (1), and radius of relative curvature (m)."""
    rolls = PAIR.roll_lengths(xi)
    own = gear == "wheel"
    return (PAIR.pinion, PAIR.wheel)[own].base_radius / rolls[own], rolls[0] * rolls[1] / (rolls[0] + rolls[1])


@pytest.mark.parametrize("gear", ["pinion", "wheel"])
def test_flanks_touch_beside_the_contact_point_of_involutes_on_a_relief(gear):
    """A slope m of the flank closes the gap by m^2 rho / 2: the minimum of s^2 / (2 rho) + m s."""
    relief = Relief(amount=4e-6, length=2e-3)
    tip, sign = (PAIR.xi_end, -1.0) if gear == "pinion" else (PAIR.xi_start, 1.0)
    xi = np.array([tip + sign * 1e-3 / PAIR.base_pitch])
    rate, radius = slope_and_curvature(gear, xi[0])
    slope = 4e-6 / 2e-3 * rate
    gap = profile_gap(PAIR, only(gear, tip_relief=relief), path_points(PAIR, xi))
    assert gap[0] == pytest.approx(2e-6 - slope**2 * radius / 2, rel=1e-3)


@pytest.mark.parametrize("gear", ["pinion", "wheel"])
@pytest.mark.parametrize(("shape", "power"), [("linear", 1), ("parabolic", 2)])
def test_tip_relief_starts_and_ends_where_it_is_asked_to(gear, shape, power):
    """So small that its slope moves the contact point by less than 0.1 % of the gap."""
    amount = 1e-9
    relief = Relief(amount=amount, length=2e-3, shape=shape)

    def gap(xi):
        return float(profile_gap(PAIR, only(gear, tip_relief=relief), path_points(PAIR, xi))[0])

    tip, sign = (PAIR.xi_end, -1.0) if gear == "pinion" else (PAIR.xi_start, 1.0)
    step = sign * 1e-3 / PAIR.base_pitch
    assert gap(tip) == pytest.approx(amount, rel=1e-3)
    assert gap(tip + step) == pytest.approx(amount * 0.5**power, rel=1e-3)
    assert gap(tip + 2.001 * step) == 0.0
    assert gap(tip - 0.1 * sign) == pytest.approx(amount, rel=1e-6)  # the edge keeps its amount


def test_start_by_diameter_is_the_same_as_by_roll_length(laws):
    low, high = active_roll(PAIR, "wheel")
    diameter = 2 * math.hypot(PAIR.wheel.base_radius, high - 2e-3)
    points = law_points(laws[0], PAIR)
    by_length, by_diameter = (
        profile_gap(PAIR, only("wheel", tip_relief=Relief(amount=8e-6, **start)), points)
        for start in ({"length": 2e-3}, {"diameter": diameter})
    )
    assert by_diameter == pytest.approx(by_length, abs=1e-15)
    assert high - low == pytest.approx(PAIR.transverse_contact_ratio * PAIR.base_pitch)


def test_root_relief_of_the_pinion_is_tip_relief_of_the_wheel(laws):
    """The same material, taken from one flank or from the other, as far as the path of contact reaches.

    So little that the contact point hardly moves along the flanks, which differ in arc per path.
    """
    points = law_points(laws[0], PAIR)
    on = (points.xi >= PAIR.xi_start) & (points.xi <= PAIR.xi_end)
    relief = Relief(amount=6e-10, length=2e-3, shape="parabolic")
    root = profile_gap(PAIR, only("pinion", root_relief=relief), points)
    tip = profile_gap(PAIR, only("wheel", tip_relief=relief), points)
    assert root[on] == pytest.approx(tip[on], abs=1e-3 * relief.amount)


def test_crownings_and_end_reliefs():
    points = law_points(Iso().law(PAIR), PAIR)
    gap = profile_gap(PAIR, only("pinion", profile_crowning=4e-9), points)
    at = np.interp([PAIR.xi_start, (PAIR.xi_start + PAIR.xi_end) / 2, PAIR.xi_end], points.xi, gap)
    assert at == pytest.approx([4e-9, 0.0, 4e-9], abs=1e-11)
    crowned = lead_gap(PAIR, only("wheel", lead_crowning=5e-6), "drive", FACE)
    assert crowned[[0, 6, 12]] == pytest.approx([5e-6, 0.0, 5e-6], abs=1e-18)
    ends = only("wheel", end_relief_low=EndRelief(amount=3e-6, length=2e-3))
    assert lead_gap(PAIR, ends, "coast", FACE)[:4] == pytest.approx([3e-6, 1.5e-6, 0, 0], abs=1e-18)
    assert (lead_gap(PAIR, ends, "drive", FACE)[3:] == 0).all()


def test_turned_helix_and_skew_open_one_flank_and_close_the_other():
    turned = only("pinion", helix_slope=6e-6)
    assert np.ptp(lead_gap(PAIR, turned, "drive", FACE)) == pytest.approx(6e-6)
    assert lead_gap(PAIR, turned, "coast", FACE) == pytest.approx(-lead_gap(PAIR, turned, "drive", FACE))
    alpha, width = PAIR.working_pressure_angle, PAIR.face_width
    skew = PairModifications(misalignment=Misalignment(out_of_plane=1e-3))
    opened = PairModifications(misalignment=Misalignment(in_plane=1e-3))
    for flank, sign in (("drive", 1), ("coast", -1)):
        slope = lead_gap(PAIR, skew, flank, FACE)
        assert slope[-1] - slope[0] == pytest.approx(sign * 1e-3 * width * math.cos(alpha))
        slope = lead_gap(PAIR, opened, flank, FACE)
        assert slope[-1] - slope[0] == pytest.approx(1e-3 * width * math.sin(alpha))


def test_misalignment_of_the_axes_is_the_tilt_of_the_bodies(laws):
    """A gap that grows along the face does what the opposite tilt psi does."""
    angle = 4e-4
    axes = PairModifications(misalignment=Misalignment(out_of_plane=angle / math.cos(PAIR.working_pressure_angle)))
    bent = modified_law(laws[0], PAIR, axes)
    cycle = np.linspace(0, 1, 20)
    tilted = LawEvaluator(laws[0]).evaluate(cycle, 5e-6, -angle)
    found = LawEvaluator(bent).evaluate(cycle, 5e-6, 0.0)
    assert found.force == pytest.approx(tilted.force, rel=1e-9)
    assert found.moment == pytest.approx(tilted.moment, rel=1e-9, abs=1e-9 * abs(tilted.moment).max())


ALL = PairModifications(
    pinion=FlankModifications(
        tip_relief=Relief(amount=9e-6, length=2e-3),
        root_relief=Relief(amount=4e-6, length=1e-3, shape="parabolic"),
        lead_crowning=3e-6,
        end_relief_high=EndRelief(amount=5e-6, length=2e-3),
        helix_slope=4e-6,
    ),
    wheel=FlankModifications(tip_relief=Relief(amount=7e-6, length=1.5e-3), profile_crowning=2e-6),
    misalignment=Misalignment(in_plane=2e-4, out_of_plane=3e-4),
)


def mirrored(modifications):
    """Seen in a mirror through both axes: hands change, what turns the helix changes its sign, faces stay."""
    pinion, wheel, axes = modifications.pinion, modifications.wheel, modifications.misalignment
    return PairModifications(
        pinion=replace(pinion, helix_slope=-pinion.helix_slope),
        wheel=replace(wheel, helix_slope=-wheel.helix_slope),
        misalignment=replace(axes, out_of_plane=-axes.out_of_plane),
    )


def test_the_coast_flank_is_the_drive_flank_of_the_pair_in_the_mirror(laws):
    other = replace(PAIR, pinion=replace(PAIR.pinion, hand="left"), wheel=replace(PAIR.wheel, hand="right"))
    twin = Plane(refinement=0.5).laws(other)
    coast = modified_law(laws[1], PAIR, ALL)
    drive = modified_law(twin[0], other, mirrored(ALL))
    cycle = np.linspace(0, 1, 30)
    seen = LawEvaluator(drive).evaluate(coast.cycle_offset - cycle, 2e-5, 2e-4)
    found = LawEvaluator(coast).evaluate(cycle, 2e-5, 2e-4)
    assert found.force == pytest.approx(seen.force, rel=1e-9)
    assert found.moment == pytest.approx(seen.moment, rel=1e-9, abs=1e-9 * abs(seen.moment).max())


def test_exchange_of_pinion_and_wheel_gives_the_same_law_backwards(laws):
    """With the wheel as driver the same flanks carry when it turns the other way, about the pinion's +y: y stays.

    Both laws interpolate on their own grid of positions, hence the tolerance.
    """
    turned = GearPair(pinion=PAIR.wheel, wheel=PAIR.pinion)
    swapped = PairModifications(pinion=ALL.wheel, wheel=ALL.pinion, misalignment=ALL.misalignment)
    one = modified_law(laws[0], PAIR, ALL)
    two = modified_law(Plane(refinement=0.5).laws(turned)[0], turned, swapped)
    cycle = np.linspace(0, 1, 40, endpoint=False) + 0.011
    first, second = LawEvaluator(one).evaluate(cycle, 2e-5, 2e-4), LawEvaluator(two).evaluate(-cycle, 2e-5, 2e-4)
    assert second.force == pytest.approx(first.force, rel=5e-4)
    assert second.moment == pytest.approx(first.moment, abs=5e-3 * np.abs(first.moment).max())


def test_as_the_load_goes_to_zero_the_error_is_the_geometric_one():
    shape = only("pinion", tip_relief=Relief(amount=1e-5, length=2e-3), profile_crowning=3e-6)
    law = modified_law(Plane(refinement=0.5).laws(SPUR)[0], SPUR, shape)
    cycle = np.linspace(0, 1, 50, endpoint=False)
    xi = law.position_start + law.position_step * np.arange(law.gap.size)
    finite = np.isfinite(law.gap)
    geometric = np.min(
        [np.interp(cycle + n, xi[finite], law.gap[finite], left=np.inf, right=np.inf) for n in (-2, -1, 0, 1)], axis=0
    )
    assert LawEvaluator(law).no_load(cycle) == pytest.approx(geometric, abs=1e-9)
    for load in (10.0, 0.1):
        above = stiffness_curve(law, load, cycle).transmission_error - geometric
        assert (above > 0).all()
        assert above.max() < 0.5e-6 * load**0.9 / 10**0.9 + 1e-9


def test_a_tilt_that_unloads_half_the_face_stays_finite_and_convex(laws):
    steep = modified_law(laws[0], PAIR, PairModifications(misalignment=Misalignment(out_of_plane=8e-3)))
    cycle = np.linspace(0, 1, 21)
    delta = np.linspace(-2e-5, 6e-5, 41)
    found = LawEvaluator(steep).evaluate(cycle[:, None], delta[None, :])
    assert np.isfinite(np.stack(found)).all()
    assert (np.diff(found.force, axis=1) >= -1e-9 * found.force.max()).all()
    curve = stiffness_curve(steep, 500.0)
    assert (curve.secant > 0).all()


def test_no_modification_leaves_the_law_alone(laws):
    assert modified_law(laws[0], PAIR, PairModifications()) is laws[0]


@pytest.mark.parametrize(
    ("modifications", "message"),
    [
        (
            only("pinion", tip_relief=Relief(amount=1e-5, diameter=60e-3)),
            "mm long, and must start on the active profile. Set diameter_mm between",
        ),
        (
            only("pinion", tip_relief=Relief(amount=1e-5, length=20e-3)),
            "mm long, and must start on the active profile. Set diameter_mm between",
        ),
        (only("wheel", lead_crowning=1e-3), "more than 0.1 modules"),
        (only("wheel", end_relief_low=EndRelief(amount=1e-5, length=7e-3)), "half the face width"),
        (
            only("wheel", tip_relief=Relief(amount=1e-5, length=6e-3), root_relief=Relief(amount=1e-5, length=6e-3)),
            "above the start of the tip relief",
        ),
    ],
)
def test_what_does_not_fit_on_the_flank_is_refused(modifications, message):
    with pytest.raises(GeometryError, match=message):
        check_modifications(PAIR, modifications)


@pytest.mark.parametrize("start", [{}, {"length": 1e-3, "diameter": 40e-3}])
def test_a_relief_needs_one_start(start):
    with pytest.raises(GeometryError, match="either length_mm or diameter_mm"):
        Relief(amount=1e-5, **start)


def test_a_steep_misalignment_is_a_mistake():
    with pytest.raises(GeometryError, match=r"0\.02"):
        Misalignment(in_plane=0.1)
