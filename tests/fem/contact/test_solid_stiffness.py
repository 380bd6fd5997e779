"""Model `solid`: against contact solutions in space and in the plane, limits, symmetries, faults, stress."""

import numpy as np
import pytest

from benchmarks.checks import solid
from benchmarks.gear_pairs import thick_rimmed_pair
from benchmarks.solid_contact import solve
from fem.contact.models.plane import Plane
from fem.contact.models.solid import Solid
from fem.contact.models.solid_stress import stress_field
from fem.contact.slice_frame import ModelError

QUICK = Solid(slices=9, refinement=0.6, positions=8)
LOAD = 100e3 * 12e-3


@pytest.fixture(scope="module")
def helical():
    return QUICK.compliance(thick_rimmed_pair(12.0))


@pytest.fixture(scope="module")
def spur():
    return QUICK.compliance(thick_rimmed_pair())


@pytest.mark.slow
def test_approach_of_a_helical_pair_against_a_contact_solution_in_space():
    """17/43, m_n 1, beta 20, b 10 mm, 2 N m at c = 0.1325: 1.222 um along the normal (full contact FE)."""
    normal, stiffness = solid.helical()
    assert normal == pytest.approx(1.222, rel=0.02)
    assert stiffness == pytest.approx(183.7, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(("cycle", "missing", "approach"), solid.calculix_positions())
def test_whole_wheels_against_calculix(cycle, missing, approach):
    """Stage 1 of the rig with full contact between whole wheels, healthy and with a missing tooth."""
    assert solid.rig_approach(cycle, missing) == pytest.approx(approach, rel=0.02)


def test_energy_is_the_potential_of_force_and_moment(helical):
    tilt, at = 4e-4, solve(helical, force=LOAD, tilt=4e-4)
    for load, turn in ((1e-4 * LOAD, 0.0), (0.0, 1e-9 / 6e-3)):
        low = solve(helical, force=LOAD - load, tilt=tilt - turn)
        high = solve(helical, force=LOAD + load, tilt=tilt + turn)
        work = at.force * (high.approach - low.approach) + at.moment * 2 * turn
        assert high.energy - low.energy == pytest.approx(work, rel=1e-5)


def test_compliances_are_symmetric_and_positive(helical):
    count = helical.gap[0].size
    for c, gap in zip(helical.compliance.reshape(-1, count, count), helical.gap, strict=True):
        here = np.isfinite(gap).ravel()
        matrix = c[np.ix_(here, here)]
        assert abs(matrix - matrix.T).max() < 1e-12 * abs(matrix).max()
        assert np.linalg.eigvalsh(matrix)[0] > 0


def test_loads_press_sum_up_and_leave_no_overlap(helical):
    state = solve(helical, force=LOAD, tilt=1e-3)
    assert (state.line_load >= 0).all()
    assert state.share.sum(axis=1) == pytest.approx(1.0, rel=1e-12)
    forces = state.line_load * helical.slice_width
    y = helical.hand * helical.face
    seen = np.einsum("cpsqt,cqt->cps", helical.compliance, forces)
    free = (state.approach + 0 * state.tilt)[:, None, None] + state.tilt[:, None, None] * y - helical.gap
    assert (free - seen)[forces == 0].max() < 1e-12
    line = np.where(forces > 0, state.line_load, 1.0)
    rest = free - seen - helical.contact_slope * line * (helical.contact_offset - np.log(line))
    assert abs(rest[forces > 0]).max() < 1e-12


def test_coast_is_the_mirror_of_drive_and_hands_mirror(helical):
    """Tilting the other way is the other flank; a left-hand pair is a right-hand one seen in the mirror."""
    drive, coast = solve(helical, force=LOAD, tilt=5e-4), solve(helical, force=LOAD, tilt=-5e-4, sign=-1)
    assert coast.approach == pytest.approx(drive.approach, rel=1e-10)
    assert coast.moment == pytest.approx(-drive.moment, rel=1e-8)
    left = solve(QUICK.compliance(thick_rimmed_pair(12.0, hands=("left", "right"))), force=LOAD, tilt=5e-4, sign=-1)
    assert left.approach == pytest.approx(drive.approach, rel=1e-9)


@pytest.mark.slow
def test_exchange_of_pinion_and_wheel_runs_the_law_backwards(helical):
    """Exact on the path; the gap of a tip edge is measured by turning the wheel, so beyond it to second order alone."""
    other = QUICK.compliance(thick_rimmed_pair(12.0, teeth=(55, 20)))
    for c in range(16):
        for p, number in enumerate(helical.pair):
            # xi -> -xi: c -> -c, p -> -p, zeta -> -zeta
            mate = np.flatnonzero(other.pair == -number + (1 if c else 0))
            if not len(mate):
                continue
            q = mate[0]
            on_path = (helical.gap[c, p] == 0) & (other.gap[-c, q][::-1] == 0)
            here, there = helical.compliance[c, p, :, p], other.compliance[-c, q, ::-1, q, ::-1]
            both = np.outer(on_path, on_path)
            assert abs(here - there)[both].max(initial=0.0) <= 1e-12 * abs(here).max()
    back = solve(helical, -np.arange(16), force=LOAD)
    assert solve(other, force=LOAD).approach == pytest.approx(back.approach, rel=2e-3)


def test_no_helix_gives_the_spur_law(spur):
    nearly = solve(QUICK.compliance(thick_rimmed_pair(0.02)), force=LOAD)
    assert nearly.approach == pytest.approx(solve(spur, force=LOAD).approach, rel=2e-3)


def test_no_load_gives_the_geometric_error_and_heavy_load_converges(helical):
    none = {0: np.inf}
    light = solve(helical, np.arange(-8, 24), force=1e-4 * LOAD, clearance=none)
    assert (light.approach - light.no_load).max() < 1e-8
    heavy = solve(helical, force=100 * LOAD)
    assert np.isfinite(heavy.approach).all()
    assert (heavy.force / heavy.approach > (solve(helical, force=LOAD).force / heavy.approach)).all()


def test_missing_tooth_of_a_spur_pair_leaves_a_gap_that_tip_edges_bridge(spur):
    """Between the pairs beside the missing one lie 2 - eps_alpha pitches without contact on the path."""
    pair = thick_rimmed_pair()
    state = solve(spur, np.arange(-16, 17), force=1e-3 * LOAD, clearance={0: np.inf})
    bridged = state.no_load > 0
    missing = (state.cycle > pair.xi_end - 1) & (state.cycle < pair.xi_start + 1)
    assert bridged.tolist() == missing.tolist()
    assert state.no_load.max() > 10e-6
    assert state.share[state.pair == 0].max() == 0.0


def test_tilt_that_unloads_half_of_the_face_moves_the_load(helical):
    state = solve(helical, force=LOAD, tilt=20e-6 / 12e-3 * 1.5)
    assert (state.line_load.sum(axis=1)[:, :3].max(axis=1) == 0).all()
    assert (state.moment / state.force > 2e-3).all()
    balanced = solve(helical, force=LOAD, tilt=None)
    assert abs(balanced.moment).max() < 1e-9 * LOAD


def test_spur_pair_at_the_pitch_point_against_contact_in_the_plane():
    """c' of one pair, 20/55, m 2, in plane strain; 2 % with free end faces."""
    record = QUICK.compliance(thick_rimmed_pair(face_mm=30))
    for line_load, stiffness in ((50e3, 15.090), (100e3, 15.547), (400e3, 16.550)):
        state = solve(record, np.array([0]), force=line_load * 30e-3)
        assert state.share[0].max() == pytest.approx(1.0, rel=1e-12)
        assert line_load / state.approach[0] / 1e9 == pytest.approx(stiffness, rel=0.02)


def test_coupling_along_the_face_is_what_plane_slices_lack(helical, spur):
    """Slices support one another: under an even load the mean is that of `plane` within 6 %, free faces the softer."""
    from fem.contact.evaluation.stiffness_curve import stiffness_curve

    for record, pair in ((spur, thick_rimmed_pair()), (helical, thick_rimmed_pair(12.0))):
        plane = stiffness_curve(Plane().law(pair, "drive"), LOAD, np.arange(16) / 16).secant.mean()
        solid = (LOAD / solve(record, force=LOAD).approach).mean()
        assert 0.93 < solid / plane < 1.0


def test_stress_field_is_held_at_the_bore_and_highest_in_loaded_teeth(helical):
    pair = thick_rimmed_pair(12.0)
    state = solve(helical, np.array([3]), force=LOAD)
    bores = (pair.pinion.bore_radius, pair.wheel.bore_radius)
    for field, bore in zip(stress_field(pair, QUICK, helical, 3, state.line_load[0]), bores, strict=True):
        radius = np.linalg.norm(field.points[..., :2], axis=2)
        assert abs(field.displacement[radius < bore * (1 + 1e-9)]).max() == 0.0
        largest = field.von_mises.max(axis=1)
        assert largest[state.share[0] > 0.2].min() > 1.5 * largest[state.share[0] == 0].max()
        assert largest.max() < 5 * 100e3 / 2e-3  # some multiples of the load over the module
        assert np.linalg.norm(field.displacement, axis=2).max() < 2 * state.approach[0]


def test_bad_options_and_impossible_loads_are_refused(spur):
    with pytest.raises(ModelError, match="slices = 1: must be 3 to 101"):
        Solid(slices=1)
    with pytest.raises(ModelError, match="no tooth pair can touch"):
        solve(spur, np.array([0]), force=1.0, clearance=dict.fromkeys(range(-3, 4), np.inf))
