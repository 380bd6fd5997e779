"""Damaged teeth: crack compliance against the whole ring and beam theory, chips and wear as gaps, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest
from mesh_laws import missing_tooth
from rings import POISSON, YOUNG, whole_ring_response
from scipy.integrate import quad

from benchmarks.gear_pairs import gear_pair
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.faults.changed_law import damaged_law
from fem.contact.faults.chipped_tooth import ChippedTooth
from fem.contact.faults.cracked_section import crack_compliance
from fem.contact.faults.cracked_tooth import CrackedTooth
from fem.contact.faults.worn_tooth import WornTooth
from fem.contact.models.plane import Plane
from fem.contact.slice_frame import law_points
from fem.contact.teeth import tooth_terms
from fem.contact.wheels import ring
from fem.gears.gear_checks import GeometryError
from fem.gears.path import path_points
from fem.gears.sector_mesh import Slit, root_chord, sector_mesh

PAIR = gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5))
SPUR = gear_pair((20, 55), 2, 0, 12, bores_mm=(12.5, 17.5))
RIGHT_ANGLE = math.pi / 2


@pytest.fixture(scope="module")
def laws():
    return Plane(refinement=0.5, patch=0.08).laws(PAIR)


def one_variant(teeth, tooth):
    variant = np.zeros(teeth)
    variant[tooth] = 1
    return tooth_terms(teeth, variant=variant)


def added(gear, depth, angle=RIGHT_ANGLE, refinement=1.0, radius=None):
    """Compliance (m2/N) that a slit adds at a radius near the tip."""
    mesh = sector_mesh(gear, refinement, Slit(depth=depth, angle=angle))
    whole = mesh.closed()
    sound = ring.reduce_sector(whole, YOUNG, POISSON, ring.flank_loads(whole))
    split = ring.reduce_sector(mesh, YOUNG, POISSON, ring.flank_loads(mesh))
    more = ring.changed_tooth(sound, split) - ring.ring_response(sound, 0)[0]
    flank = ring.FlankCompliance(arc=mesh.flank_arc, tip_arc=mesh.tip_arc, matrix={0: more})
    radius = gear.tip_radius - 0.15 * gear.normal_module if radius is None else radius
    centre = np.array([(radius**2 - gear.base_radius**2) / (2 * gear.base_radius)])
    weight = flank.patches(centre, 0.08 * gear.normal_module)[0][0]
    return float(weight @ more @ weight)


@pytest.mark.parametrize(("beta_deg", "angle_deg"), [(0.0, 90.0), (20.0, 60.0)])
def test_a_cracked_tooth_in_the_condensed_ring_equals_the_ring_meshed_as_a_whole(beta_deg, angle_deg):
    gear = gear_pair((12, 30), 2, beta_deg, 12, bores_mm=(5.0, 15.0)).pinion
    mesh = sector_mesh(gear, 0.5, Slit(depth=0.4 * root_chord(gear)[1], angle=math.radians(angle_deg)))
    loads = ring.flank_loads(mesh)[:, 8::12]
    whole = mesh.closed()
    sound = ring.reduce_sector(whole, YOUNG, POISSON, ring.flank_loads(whole)[:, 8::12])
    found = ring.changed_tooth(sound, ring.reduce_sector(mesh, YOUNG, POISSON, loads))
    direct = whole_ring_response(mesh, loads, [0], slit_on=0)[0]
    assert abs(found - direct).max() < 1e-9 * abs(direct).max()
    assert np.diag(direct)[-1] > 1.3 * np.diag(ring.ring_response(sound, 0)[0])[-1]


def test_a_crack_bends_as_fracture_mechanics_says():
    """Edge crack in a strip under bending and compression (Tada, Paris & Irwin, 2.10 and 2.13): dC = int 2 K^2/E' da.

    The fillet concentrates stress at a shallow crack, which the strip does not know, so the ratio falls to 1.
    """
    gear = gear_pair((40, 55), 2, 0, 12, bores_mm=(25, 35)).pinion
    foot, width = root_chord(gear)
    radius = gear.tip_radius - 0.15 * gear.normal_module
    lean = gear.pressure_angle_at(radius) - gear.half_thickness_angle(radius)
    arm = (gear.base_radius / math.cos(lean) - math.sqrt(foot**2 - width**2 / 4)) * math.cos(lean)

    def intensity(part):
        wave = math.sqrt(2 / (math.pi * part) * math.tan(math.pi * part / 2)) / math.cos(math.pi * part / 2)
        rest = 1 - math.sin(math.pi * part / 2)
        bending = 6 * arm / width**2 * wave * (0.923 + 0.199 * rest**4)
        tension = -math.sin(lean) / width * wave * (0.752 + 2.02 * part + 0.37 * rest**3)
        return (bending + tension) * math.sqrt(math.pi * part * width)

    ratios = []
    for part in (0.1, 0.3, 0.5):
        strip = quad(lambda x: 2 * (1 - POISSON**2) / YOUNG * intensity(x) ** 2 * width, 1e-6, part)[0]
        ratios.append(added(gear, part * width) / strip)
    assert ratios == sorted(ratios, reverse=True)
    assert ratios[0] < 1.45
    assert ratios[-1] == pytest.approx(1.0, abs=0.05)


def test_crack_compliance_grows_with_depth_from_nothing():
    chord = root_chord(SPUR.pinion)[1]
    grown = [added(SPUR.pinion, part * chord, math.radians(70), 0.6) for part in (0.01, 0.2, 0.4, 0.6)]
    assert grown[0] < 3e-3 * grown[2]
    assert (np.diff(grown, n=2) > 0).all()  # the trend of the literature: faster and faster


@pytest.mark.slow
def test_crack_compliance_converges():
    gear = PAIR.pinion
    chord = root_chord(gear)[1]
    coarse, fine = (added(gear, 0.3 * chord, math.radians(70), size) for size in (0.6, 1.2))
    assert coarse == pytest.approx(fine, rel=0.03)


def test_a_crack_softens_its_own_flank_in_its_slices_only(laws):
    crack = CrackedTooth(depth=1.5e-3, extent=4e-3, end="-y")
    drive, coast = (damaged_law(law, PAIR, "wheel", [crack]) for law in laws)
    cracked = drive.wheel_variant_compliance[0]
    assert (cracked[drive.face_coordinate < -2e-3] > 0).all()
    assert (cracked[drive.face_coordinate > -2e-3] == 0).all()
    assert (coast.wheel_variant_compliance == 0).all()
    alone = crack_compliance(PAIR, "wheel", crack.depth, crack.angle, law_points(drive, PAIR), 0.5)
    assert cracked[0] == pytest.approx(alone)
    assert alone[0] > 2 * alone[-1]  # the wheel tip comes first on the path and bends most
    teeth = one_variant(55, 0)
    sound, soft = (LawEvaluator(drive).evaluate(np.linspace(-1.5, 1.5, 60), 5e-6, 0.0, None, t) for t in (None, teeth))
    change = sound.force - soft.force
    assert (change >= -1e-9 * sound.force).all()
    assert change.max() > 0.01 * sound.force.max()
    assert change[[0, -1]] == pytest.approx(0.0, abs=1e-9 * sound.force.max())


def test_a_chip_over_the_whole_face_and_height_is_a_missing_tooth(laws):
    height = PAIR.pinion.tip_radius - PAIR.pinion.root_radius
    law = damaged_law(laws[0], PAIR, "pinion", [ChippedTooth(extent=12e-3, depth=height)])
    cycle = np.linspace(-2, 2, 81)
    chipped = LawEvaluator(law).evaluate(cycle, 6e-6, 1e-4, one_variant(20, 0))
    gone = LawEvaluator(law).evaluate(cycle, 6e-6, 1e-4, missing_tooth(np.zeros(20), 0))
    assert chipped.force == pytest.approx(gone.force, rel=1e-12)
    assert chipped.moment == pytest.approx(gone.moment, rel=1e-12)


def test_a_chip_cuts_the_path_short_where_the_tip_is_lost():
    law = Plane(refinement=0.5, slices=12).laws(SPUR)[0]
    law = damaged_law(law, SPUR, "pinion", [ChippedTooth(extent=3e-3, depth=1e-3, end="+y")])
    gap = law.pinion_variant_gap[0]
    lost = law.face_coordinate > 3e-3
    assert lost.sum() == 3
    assert (gap[~lost] == 0).all()
    xi = law.position_start + law.position_step * np.arange(law.gap.size)
    edge = SPUR.pinion.tip_radius - 1e-3
    end = (math.sqrt(edge**2 - SPUR.pinion.base_radius**2) - SPUR.roll_lengths(0.0)[0]) / SPUR.base_pitch
    assert (gap[lost][:, xi <= end] == 0).all()
    beyond = gap[lost][:, (xi > end) & np.isfinite(law.gap)]
    assert (beyond > 0).all()
    shorter = path_points(SPUR, xi, 1e-3, (edge, np.inf)).gap
    place = (xi > end) & (xi < SPUR.xi_end)
    assert gap[lost][0, place] == pytest.approx(shorter[place])


def test_the_material_that_a_chip_takes_away_hardly_supported_what_is_left():
    """A chip keeps the compliance of the whole tooth. Against a wheel that is made half a module shorter."""
    short = replace(SPUR, wheel=replace(SPUR.wheel, tip_alteration=-1e-3))
    whole, cut = (Plane(refinement=0.7, slices=1).laws(pair)[0] for pair in (SPUR, short))
    below = short.wheel.tip_radius - law_points(cut, short).wheel_radius
    xi = [law.position_start + law.position_step * np.arange(law.compliance.size) for law in (whole, cut)]
    added = cut.compliance / np.interp(xi[1], xi[0], whole.compliance) - 1.0
    flank = np.isfinite(cut.gap) & (cut.gap == 0.0)
    assert 0.005 < added[flank].max() < 0.04
    assert np.abs(added[flank & (below > 0.3e-3)]).max() < 6e-3
    assert np.abs(added[flank & (below > 0.7e-3)]).max() < 2e-3


def test_a_broken_corner_is_deepest_at_its_end():
    chip = ChippedTooth(extent=4e-3, depth=2e-3, end="-y", corner=True)
    depth = chip.depth_at(np.array([-6e-3, -4e-3, -2e-3, 0.0]), 12e-3)
    assert depth == pytest.approx([2e-3, 1e-3, 0.0, 0.0])


def test_even_wear_of_a_tooth_is_its_clearance(laws):
    law = damaged_law(laws[0], PAIR, "wheel", [WornTooth(depth=7e-6)])
    cycle = np.linspace(-2, 2, 41)
    worn = LawEvaluator(law).evaluate(cycle, 1e-5, 0.0, None, one_variant(55, 0))
    clearance = np.zeros(55)
    clearance[0] = 7e-6
    assert worn.force == pytest.approx(LawEvaluator(law).evaluate(cycle, 1e-5, 0.0, None, clearance).force, rel=1e-12)


def test_local_wear_stays_in_its_place(laws):
    law = laws[0]
    at_pitch, at_root = (
        damaged_law(law, PAIR, "pinion", [WornTooth(depth=9e-6, place=place, width=2e-3)]).pinion_variant_gap[0, 0]
        for place in ("pitch", "root")
    )
    xi = law.position_start + law.position_step * np.arange(law.gap.size)
    assert np.interp(0.0, xi, at_pitch) == pytest.approx(9e-6, rel=1e-3)
    assert at_pitch[np.abs(xi) > 1e-3 / PAIR.base_pitch + 1e-9] == pytest.approx(0.0, abs=1e-18)
    assert np.interp(PAIR.xi_start, xi, at_root) == pytest.approx(9e-6, rel=0.02)
    assert (at_root[xi > PAIR.xi_start + 1e-3 / PAIR.base_pitch] < 1e-18).all()


def test_without_a_tooth_spur_gears_drop_onto_the_tip_edges_of_the_neighbours():
    """No contact for 2 - eps_alpha pitches on the line of action: there delta_0 is the gap of the nearer tip edge."""
    law = Plane(refinement=0.5, slices=1).laws(SPUR)[0]
    gone = missing_tooth(np.zeros(20), 0)
    cycle = np.linspace(-1, 1, 401)
    error = LawEvaluator(law).no_load(cycle, pinion=gone)
    open_part = (error > 1e-9).mean() * 2
    assert open_part == pytest.approx(2 - SPUR.transverse_contact_ratio, abs=0.02)
    expected = np.minimum(path_points(SPUR, cycle + 1, 1e-3).gap, path_points(SPUR, cycle - 1, 1e-3).gap)
    assert error == pytest.approx(expected, abs=0.01 * expected.max())
    assert 10e-6 < error.max() < 100e-6
    middle = cycle[np.argmax(error)]
    pairs, force = LawEvaluator(law).shares(float(middle), float(error.max()) + 30e-6, 0.0, gone)
    assert set(pairs[force > 0]) <= {-1, 1}
    assert force.sum() > 0


def test_where_lines_overlap_a_missing_tooth_opens_no_gap():
    wide = gear_pair((20, 55), 2, 15, 30, bores_mm=(12.5, 17.5))
    law = Plane(refinement=0.5).laws(wide)[0]
    error = LawEvaluator(law).no_load(np.linspace(-2, 2, 161), pinion=missing_tooth(np.zeros(20), 0))
    assert error == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (CrackedTooth(depth=4e-3), "of the tooth root thickness"),
        (CrackedTooth(depth=1e-3, extent=13e-3), "extent"),
        (ChippedTooth(extent=13e-3, depth=1e-3), "the face width"),
        (ChippedTooth(extent=3e-3, depth=5e-3), "the tooth height"),
        (WornTooth(depth=1e-3), "0.2 modules"),
        (WornTooth(depth=1e-5, place="root"), "width_mm is the width of local wear. Set it"),
    ],
)
def test_damage_that_does_not_fit_is_refused(fault, message):
    with pytest.raises(GeometryError, match=message):
        fault.check(PAIR.pinion)


@pytest.mark.parametrize(
    ("fault", "given", "message"),
    [
        (CrackedTooth, {"depth": 1e-3, "angle": math.radians(20)}, "angle = 20 deg: must be 40 to 90 deg"),
        (ChippedTooth, {"extent": 3e-3, "depth": 1e-3, "end": "left"}, "end = 'left': must be one of '-y', '\\+y'"),
        (WornTooth, {"depth": 0.0}, "depth = 0 um: must be above 0 um"),
    ],
)
def test_a_value_outside_the_range_of_its_option_is_refused(fault, given, message):
    with pytest.raises(GeometryError, match=message):
        fault(**given)


def test_a_crack_towards_a_thin_rim_is_refused():
    rim = gear_pair((20, 55), 2, 0, 12, bores_mm=(15.0, 17.5)).pinion
    with pytest.raises(GeometryError, match="30 % of the rim"):
        CrackedTooth(depth=2.8e-3, angle=math.radians(40)).check(rim)


def test_stiffness_falls_while_a_cracked_tooth_carries(laws):
    law = damaged_law(laws[0], PAIR, "pinion", [CrackedTooth(depth=2e-3)])
    cycle = np.linspace(-2.5, 2.5, 101)
    sound = stiffness_curve(law, 1000.0, cycle).secant
    soft = stiffness_curve(law, 1000.0, cycle, clearance_pinion=one_variant(20, 0)).secant
    ratio = soft / sound
    assert 0.7 < ratio.min() < 0.95
    assert ratio[np.abs(cycle) > 1.6] == pytest.approx(1.0, abs=1e-9)
