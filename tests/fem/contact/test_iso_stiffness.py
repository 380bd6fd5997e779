"""Model iso: published stiffness figures, exact mean, shape of the contact line, limits in helix angle and load."""

import math
from dataclasses import replace

import numpy as np
import pytest
from mesh_laws import missing_tooth

from benchmarks.gear_pairs import gear_pair, kisssoft_helical, kisssoft_spur, line_length
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.models.iso import Iso, blank_factor, rack_factor
from fem.contact.slice_frame import ModelError, flank_frame
from fem.elements.materials import CAST_IRON, STEEL, Material, MaterialError

PER_MM_UM = 1e9


def stiffness(pair, **options):
    found = Iso(**options).stiffness(pair)
    return [value / PER_MM_UM for value in (found.single, found.mean, found.mean_for_distribution)]


def test_published_helical_pair():
    """KISSsoft report 03/2017 published in gfsReboucas/Drivetrain: c', c_gamma_alpha, c_gamma_beta, C_R, C_B."""
    solid = kisssoft_helical()
    pinion, wheel = (
        replace(gear, rim_thickness=5 * gear.normal_module, web_thickness=gear.face_width / 4)
        for gear in (solid.pinion, solid.wheel)
    )
    pair = replace(solid, pinion=pinion, wheel=wheel)
    assert blank_factor(0.25, 5.0) == pytest.approx(0.898, rel=1e-3)
    assert rack_factor(pair.pinion) == pytest.approx(0.975, rel=1e-12)
    found = stiffness(pair, line_load=666.85e3)
    assert found == pytest.approx([13.832, 18.632, 15.837], rel=1e-3)


def test_published_spur_pair():
    assert stiffness(kisssoft_spur(), blank_factor=0.862) == pytest.approx([12.240, 15.640, 13.294], rel=1e-3)


@pytest.mark.parametrize(("helix", "single", "mean"), [(0, 13.07, 19.57), (12, 12.94, 18.90), (15, 12.87, 18.52)])
def test_standard_arithmetic(helix, single, mean):
    assert stiffness(gear_pair((20, 55), 2, helix, 30))[:2] == pytest.approx([single, mean], rel=2e-3)


def test_low_load_and_soft_material_lower_the_stiffness():
    pair = gear_pair((20, 55), 2, 12, 30)
    full = Iso().stiffness(pair).single
    assert Iso(line_load=40e3).stiffness(pair).single == pytest.approx(full * 0.4**0.25, rel=1e-12)
    assert Iso(line_load=100e3).stiffness(pair).single == full
    mixed = gear_pair((20, 55), 2, 12, 30, wheel_material=CAST_IRON)
    e1, e2 = STEEL.elastic_modulus, CAST_IRON.elastic_modulus
    assert Iso().stiffness(mixed).single == pytest.approx(full * 2 * e2 / (e1 + e2), rel=1e-12)


def test_blank_factor_limits():
    assert blank_factor(1.0, 5.0) == 1.0
    assert blank_factor(0.1, 5.0) == blank_factor(0.2, 5.0)
    assert blank_factor(2.0, 0.5) == blank_factor(1.2, 1.0)


@pytest.mark.parametrize(
    ("helix", "face", "tolerance"), [(0, 12, 1e-3), (12, 12, 1e-6), (15, 30, 1e-6), (25, 40, 1e-6)]
)
def test_mean_over_a_pitch_is_the_standard_value(helix, face, tolerance):
    """k along the transverse line of action, F_bt = c_gamma_alpha b delta."""
    pair = gear_pair((20, 55), 2, helix, face)
    cycle = (np.arange(4000) + 0.5) / 4000
    mean = LawEvaluator(Iso().law(pair)).evaluate(cycle, 5e-6).stiffness.mean()
    assert mean == pytest.approx(Iso().stiffness(pair).mean * pair.face_width, rel=tolerance)


@pytest.mark.parametrize(("helix", "face"), [(12, 12), (15, 30), (25, 40)])
@pytest.mark.parametrize("flank", ["drive", "coast"])
def test_shape_is_the_contact_line_length(helix, face, flank):
    pair = gear_pair((20, 55), 2, helix, face)
    law = Iso().law(pair, flank)
    cycle = np.linspace(0, 1, 401)
    own = law.cycle_sign * cycle + law.cycle_offset
    mean = pair.transverse_contact_ratio * pair.face_width / math.cos(pair.base_helix_angle)
    stiffness = LawEvaluator(law).evaluate(cycle, 5e-6).stiffness / (Iso().stiffness(pair).mean * pair.face_width)
    assert stiffness == pytest.approx(line_length(pair, own) / mean, abs=2e-4)


def test_helix_to_zero_gives_the_spur_law():
    spur, nearly = gear_pair((20, 55), 2, 0, 12), gear_pair((20, 55), 2, 1e-4, 12)
    cycle = np.linspace(0, 1, 101)
    ends = np.array([spur.xi_start, spur.xi_end])
    away = (np.abs((cycle[:, None] - ends + 0.5) % 1.0 - 0.5) > 0.01).all(axis=1)
    a, b = (LawEvaluator(Iso().law(pair)).evaluate(cycle[away], 5e-6).force for pair in (spur, nearly))
    assert a == pytest.approx(b, rel=1e-6)


def test_stiffness_responds_to_the_helix():
    laws = (LawEvaluator(Iso().law(gear_pair((20, 55), 2, beta, 12))) for beta in (0, 6, 12, 20))
    peaks = [np.ptp(law.evaluate(np.linspace(0, 1, 200), 5e-6).stiffness) for law in laws]
    assert (np.diff(peaks) < 0).all()
    means = [Iso().stiffness(gear_pair((20, 55), 2, beta, 12)).mean for beta in (0, 10, 20, 30)]
    assert (np.diff(means) < 0).all()


def test_tilt_stiffness_of_a_full_line():
    """With a pair in contact over the whole face dM/d psi = k b^2 / 12 (slices: less by 1 / n^2)."""
    pair = gear_pair((20, 55), 2, 0, 12)
    r = LawEvaluator(Iso(slices=20).law(pair)).evaluate(0.0, 5e-6)
    assert r.tilt_stiffness == pytest.approx(r.stiffness * 0.012**2 / 12 * (1 - 1 / 400), rel=1e-9)
    assert r.cross_stiffness == pytest.approx(0.0, abs=1e-9 * float(r.stiffness))


def test_missing_tooth_lowers_the_stiffness_by_its_line():
    pair = gear_pair((20, 55), 2, 12, 12)
    law = Iso(edge_onset=0.025).law(pair)
    cycle = np.linspace(-1.5, 1.5, 301)
    broken = LawEvaluator(law).evaluate(cycle, 5e-6, 0.0, None, missing_tooth(np.zeros(55), 0)).stiffness
    mean = pair.transverse_contact_ratio * pair.face_width / math.cos(pair.base_helix_angle)
    expected = line_length(pair, cycle, missing=True) / mean
    assert broken / (Iso().stiffness(pair).mean * pair.face_width) == pytest.approx(expected, abs=2e-4)


def test_spur_gears_drop_onto_the_tip_edges_where_a_tooth_is_missing():
    pair = gear_pair((20, 55), 2, 0, 12)
    cycle = np.linspace(-1.0, 1.0, 201)
    curve = stiffness_curve(Iso().law(pair), 500.0, cycle, clearance_wheel=missing_tooth(np.zeros(55), 0))
    alone = (cycle > pair.xi_end - 1 + 0.01) & (cycle < pair.xi_start + 1 - 0.01)  # no other pair on its path
    assert alone.sum() > 30
    assert (curve.no_load_error[alone] >= 20e-6).all()
    assert curve.no_load_error.max() < 60e-6
    assert (curve.no_load_error[np.abs(cycle) > 0.4] == 0.0).all()


@pytest.mark.parametrize("beta", [0, 15])
def test_gears_of_one_shape_have_one_law_whatever_their_size(beta):
    """Lengths scale with the module, the stiffness of a contact line per metre does not depend on it."""
    small, usual, large = (Iso().law(gear_pair((20, 55), m, beta, 10 * m)) for m in (0.5, 2, 10))
    for law, module in ((small, 0.5), (large, 10)):
        assert law.gap == pytest.approx(usual.gap * module / 2, rel=1e-9)
        assert law.compliance == pytest.approx(usual.compliance, rel=1e-12)
        assert law.fraction == pytest.approx(usual.fraction, abs=1e-9)


@pytest.mark.parametrize(("teeth", "module"), [((125, 125), 0.5), ((200, 300), 1), ((400, 400), 1), ((2000, 2000), 1)])
def test_many_fine_teeth_carry_like_any_others(teeth, module):
    """Tip edges of gears with many teeth part slowly; the mean stiffness is still that of the standard."""
    pair = gear_pair(teeth, module, 0, 10)
    law = Iso(slices=1).law(pair)
    cycle = (np.arange(600) + 0.5) / 600
    mean = LawEvaluator(law).evaluate(cycle, 5e-3 * 1e-3 * module).stiffness.mean()
    assert mean == pytest.approx(Iso().stiffness(pair).mean * pair.face_width, rel=2e-3)
    edges = law.gap[np.isfinite(law.gap)][[0, -1]]
    assert edges == pytest.approx(np.full(2, 0.05e-3 * module), rel=0.01)


def test_the_neighbours_of_a_missing_tooth_take_over_at_any_size():
    """A short path of contact needs edges with larger gaps, in proportion to the module."""
    drops = []
    for module in (0.5, 5):
        law = Iso().law(gear_pair((17, 30), module, 0, 10 * module, tip_mm=-0.2 * module))
        start = LawEvaluator(law).no_load(np.linspace(-1, 1, 81), pinion=missing_tooth(np.zeros(17), 0))
        drops.append(start.max() / module)
    assert drops[0] == pytest.approx(drops[1], rel=1e-9)
    assert 0.05e-3 < drops[0] < 0.4e-3


@pytest.mark.parametrize(
    ("pair", "message"),
    [
        (gear_pair((20, 55), 2, 35, 30), "the helix angle 35 deg is above"),
        (gear_pair((20, 55), 2, 0, 12, tip_mm=-0.7), "the contact ratio 1.1"),
        (gear_pair((60, 90), 2, 0, 12, (-0.3, -0.3), tip_mm=-0.1), "sum of profile shifts -0.6 is"),
        (gear_pair((60, 90), 2, 0, 12, (1.05, 1.05), tip_mm=-0.4), "sum of profile shifts 2.1 is"),
    ],
)
def test_outside_the_standard_is_refused(pair, message):
    with pytest.raises(ModelError, match=message):
        Iso().law(pair)


def test_bad_options_are_refused():
    with pytest.raises(ModelError, match="slices"):
        Iso(slices=0)


def test_unknown_flank_is_refused():
    with pytest.raises(ModelError, match="drive, coast"):
        Iso().law(gear_pair((20, 55), 2, 0, 12), "left")


def test_impossible_material_is_refused():
    with pytest.raises(MaterialError, match="poisson_ratio"):
        Material(name="rubber", elastic_modulus=1e6, poisson_ratio=0.5, density=1000.0)


@pytest.mark.parametrize("helix", [0, 12])
def test_coast_flanks_touch_where_the_frame_says(helix):
    """Without backlash, place both gears at cycle c and look at the mirrored line of action, tooth by tooth."""
    pair = gear_pair((20, 55), 2, helix, 12, (0.3, -0.1))
    frame = flank_frame(pair, "coast", 1)
    (r1, r2), alpha = pair.working_radii, pair.working_pressure_angle
    for c in (0.0, 0.27, 7.9):
        own = frame["cycle_sign"] * c + frame["cycle_offset"]
        for p in range(math.ceil(own - pair.xi_end), math.floor(own - pair.xi_start) + 1):
            i = frame["cycle_sign"] * p
            j = i + frame["wheel_tooth_offset"]
            along = (own - p) * pair.base_pitch
            point = r1 + along * math.sin(alpha) - 1j * along * math.cos(alpha)
            for gear, centre, middle in (
                (pair.pinion, 0.0, 2 * math.pi * (c - i) / 20 - pair.pinion.half_thickness_angle(r1)),
                (
                    pair.wheel,
                    pair.axis_distance,
                    math.pi - 2 * math.pi * (c - j) / 55 - pair.wheel.half_thickness_angle(r2),
                ),
            ):
                seen = point - centre
                flank = middle - gear.half_thickness_angle(abs(seen))
                assert np.exp(1j * flank) == pytest.approx(seen / abs(seen), abs=1e-9)


def test_a_right_hand_pinion_meets_first_at_positive_face_coordinate():
    pair = gear_pair((20, 55), 2, 12, 12)
    drive, coast = (flank_frame(pair, flank, 5)["cycle_shift"] for flank in ("drive", "coast"))
    assert drive[-1] - drive[0] == pytest.approx(0.8 * pair.overlap_ratio)
    assert coast == pytest.approx(-drive)
