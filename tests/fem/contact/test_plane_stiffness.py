"""Model `plane`: ring against published tooth compliances and a whole ring, contact split, limits of the law."""

import math

import numpy as np
import pytest
from rings import whole_ring_response

from benchmarks.checks import plane
from benchmarks.gear_pairs import gear, thick_rimmed_pair
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.models.plane import Plane
from fem.contact.slice_frame import ModelError
from fem.contact.wheels import ring
from fem.gears.sector_mesh import sector_mesh

YOUNG, POISSON = 206e9, 0.3


def spur_law(**options):
    return Plane(slices=1, **options).law(thick_rimmed_pair(face_mm=30), "drive")


@pytest.fixture(scope="module")
def spur():
    return spur_law()


@pytest.fixture(scope="module")
def helical():
    return Plane(slices=11).laws(thick_rimmed_pair(12.0, 12))


def loaded(law, cycle, force, psi=0.0):
    """delta (m) at which the law carries `force` (N)."""
    return float(LawEvaluator(law).approach_at(force, cycle, psi)[0])


# --- the ring ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("teeth", "beta_deg"), [(11, 0.0), (12, 20.0)])
def test_condensed_ring_equals_the_ring_meshed_as_a_whole(teeth, beta_deg):
    mesh = sector_mesh(gear(teeth, helix_deg=beta_deg), refinement=0.5)
    loads = ring.flank_loads(mesh)[:, ::10]
    found = ring.ring_response(ring.reduce_sector(mesh, YOUNG, POISSON, loads))
    direct = whole_ring_response(mesh, loads, range(-2, 3))
    for tooth, matrix in direct.items():
        assert abs(found[tooth] - matrix).max() < 1e-9 * abs(direct[0]).max()


def test_removing_a_tooth_hardly_changes_its_neighbours():
    """The missing tooth is a missing contact alone; what its body adds to the rim is about a tenth of a per cent."""
    mesh = sector_mesh(gear(20), refinement=0.5)
    columns = np.linspace(8, len(mesh.flank) - 4, 5).astype(int)
    loads = ring.flank_loads(mesh)[:, columns]
    healthy = np.diag(whole_ring_response(mesh, loads, [0])[0])
    for missing in (-1, 1):
        change = np.diag(whole_ring_response(mesh, loads, [0], missing)[0]) / healthy - 1
        assert (change > 0).all()
        assert change.max() < 0.004


@pytest.mark.parametrize(
    ("teeth", "radius", "published"),
    [(17, 8.0023, 0.01626), (17, 8.5, 0.02226), (43, 21.5, 0.02085), (43, 22.4434, 0.05411)],
)
def test_tooth_compliance_seen_on_the_centre_line(teeth, radius, published):
    """Displacement (um per N/mm) along the load line where it crosses the tooth centre line; module 1 mm, x 0.

    Two independent plane strain solutions agree on these figures; the load is a line load, here on a narrow patch.
    """
    assert plane.tooth_compliance(teeth, radius) == pytest.approx(published, rel=0.005)


@pytest.mark.parametrize("beta_deg", [0.0, 25.0])
def test_flank_compliances_are_reciprocal_and_positive(beta_deg):
    mesh = sector_mesh(gear(18, helix_deg=beta_deg))
    flank = ring.flank_compliance(mesh, YOUNG, POISSON)
    for n in (0, 1, 2):
        assert abs(flank.matrix[n] - flank.matrix[-n].T).max() < 1e-11 * abs(flank.matrix[0]).max()
    weight, _ = flank.patches(np.linspace(mesh.form_arc, mesh.tip_arc, 7), 0.1e-3)
    teeth = range(-1, 2)
    whole = np.block([[weight @ flank.matrix[i - j] @ weight.T for j in teeth] for i in teeth])
    assert np.linalg.eigvalsh(whole)[0] > 0


def test_normal_loads_turn_the_gear_with_the_base_radius():
    for beta_deg in (0.0, 23.0):
        g = gear(23, helix_deg=beta_deg)
        mesh = sector_mesh(g)
        loads = ring.flank_loads(mesh).toarray().reshape(len(mesh.points), -1, len(mesh.flank))
        moment = np.einsum("n,np->p", mesh.points[:, 0], loads[:, 1]) - np.einsum(
            "n,np->p", mesh.points[:, 1], loads[:, 0]
        )
        assert moment[mesh.flank_arc >= mesh.form_arc] == pytest.approx(-g.base_radius, rel=1e-12)
        if beta_deg:
            axial = loads[:, 2].sum(axis=0)[mesh.flank_arc >= mesh.form_arc]
            assert axial == pytest.approx(math.tan(g.helix_angle) / g.reference_radius * g.base_radius, rel=1e-12)


def test_patches_have_unit_sum_and_the_variance_of_an_ellipse():
    mesh = sector_mesh(gear(20))
    flank = ring.FlankCompliance(arc=mesh.flank_arc, tip_arc=mesh.tip_arc, matrix={})
    centre = (mesh.form_arc + mesh.tip_arc) / 2
    weight, used = flank.patches(np.array([centre, 1.0]), 0.16e-3)
    assert weight.sum(axis=1) == pytest.approx(1.0, rel=1e-13)
    assert used == pytest.approx([0.16e-3, 0.08e-3], rel=1e-12)
    assert weight[1] @ mesh.flank_arc == pytest.approx(mesh.tip_arc - 0.08e-3, rel=1e-6)
    assert weight[0] @ mesh.flank_arc == pytest.approx(centre, rel=1e-6)
    assert weight[0] @ (mesh.flank_arc - centre) ** 2 == pytest.approx(0.16e-3**2 / 4, rel=1e-3)


# --- the contact ------------------------------------------------------------------------------------------------------


def test_contact_split_on_a_half_plane():
    """mean u = u(0) - K f / 4 for an elliptical pressure; u = -K int p ln|x - s| ds, sources between the places."""
    n = 2000
    source, place = np.cos(np.pi * (np.arange(n) + 0.5) / n), np.cos(np.pi * np.arange(n + 1) / n)
    part = 2 / n * (1 - source**2)  # p ds of unit resultant on (-1, 1)
    shape = -np.log(np.abs(place[:, None] - source)) @ part
    inner = abs(place) < 0.98
    assert shape[inner] == pytest.approx(np.log(2) + 0.5 - place[inner] ** 2, abs=1e-3)
    mean = (2 / n * (1 - place**2)) @ shape
    assert shape[n // 2] - mean == pytest.approx(0.25, abs=5e-4)


def test_single_pair_stiffness_against_a_contact_solution(spur):
    """c' = f / x at the pitch point, 20/55, m 2: against plane strain contact of the true flanks."""
    for load, truth in ((50e3, 15.090), (100e3, 15.547), (400e3, 16.550)):
        assert load / plane.approach(spur, load) / 1e9 == pytest.approx(truth, rel=0.005)


@pytest.mark.slow
def test_result_is_independent_of_the_patch_and_of_the_mesh(spur):
    variants = [spur_law(refinement=2.0, patch=patch) for patch in (0.04, 0.08)]
    for xi in (-0.6, -0.3, 0.0, 0.3, 0.6):
        values = [plane.approach(law, 100e3, xi) for law in (spur, *variants)]
        assert np.ptp(values) < 0.002 * values[0]


def test_compliance_converges_with_refinement():
    reference, *others = [plane.approach(spur_law(refinement=r, patch=0.1), 100e3) for r in (2.0, 0.5, 1.0)]
    errors = [abs(value / reference - 1) for value in others]
    assert errors[0] < 0.005
    assert errors[1] < errors[0] / 3


def test_helical_approach_against_a_contact_solution_in_space():
    """17/43, m_n 1, beta 20, b 10 mm, T1 2 N m at c = 0.1325: approach normal to the flank 1.222 um (3-D contact FE).

    Straight-tooth plane strain in the transverse section would be 11 % too stiff.
    """
    normal, stiffness = plane.helical_state()
    assert normal == pytest.approx(1.222, rel=0.03)
    assert stiffness == pytest.approx(183.7, rel=0.03)


# --- the law ----------------------------------------------------------------------------------------------------------


def test_no_helix_gives_the_spur_law(spur):
    nearly = Plane(slices=1).law(thick_rimmed_pair(0.01, 30), "drive")
    assert nearly.compliance == pytest.approx(spur.compliance, rel=1e-4)
    assert nearly.neighbour_compliance == pytest.approx(spur.neighbour_compliance, rel=2e-4)
    assert nearly.contact_slope == pytest.approx(spur.contact_slope, rel=1e-6)


def test_stiffness_responds_to_the_helix(spur, helical):
    """c' falls with the helix angle as in ISO 6336-1, clause 9: cos(beta) / q'(z_n1, z_n2), z_n the virtual teeth."""

    def iso(beta_deg):
        pair = thick_rimmed_pair(beta_deg, 30)
        flexibility = 0.04723 + 0.15551 / pair.pinion.virtual_teeth + 0.25791 / pair.wheel.virtual_teeth
        return math.cos(math.radians(beta_deg)) / flexibility

    for beta_deg, law in ((12.0, helical[0]), (25.0, Plane(slices=1).law(thick_rimmed_pair(25.0, 30), "drive"))):
        found = plane.approach(spur, 100e3) / plane.approach(law, 100e3)
        assert found < 1
        assert found == pytest.approx(iso(beta_deg) / iso(0.0), rel=0.012)


def test_shares_sum_to_the_force_and_the_law_is_periodic(helical):
    law = LawEvaluator(helical[0])
    for cycle in (0.0, 0.37, 0.81):
        _, share = law.shares(cycle, 6e-6, 1e-4)
        force = law.evaluate(cycle, 6e-6, 1e-4).force
        assert (share >= 0).all()
        assert share.sum() == pytest.approx(force, rel=1e-12)
        assert law.evaluate(cycle + 3, 6e-6, 1e-4).force == pytest.approx(force, rel=1e-9)


def test_coast_is_the_mirror_image_of_drive(helical):
    drive, coast = helical
    lag = thick_rimmed_pair(12.0, 12).thickness_cycle
    for u in (0.1, 0.55):
        ahead = LawEvaluator(drive).evaluate(u, 5e-6, 2e-4)
        mirrored = LawEvaluator(coast).evaluate(lag - u, 5e-6, -2e-4)
        assert mirrored.force == pytest.approx(ahead.force, rel=1e-9)
        assert mirrored.moment == pytest.approx(-ahead.moment, rel=1e-9)
    assert (coast.cycle_sign, coast.wheel_tooth_offset) == (-1, 1)


def test_mean_stiffness_is_about_a_tenth_above_iso(helical):
    """ISO 6336-1 for 20/55, beta 12: c_gamma_alpha 18.90 N/(mm um) at 100 N/mm, which contains C_M = 0.8."""
    force = 100e3 * 12e-3
    mean = np.mean([force / loaded(helical[0], c, force) for c in np.arange(16) / 16]) / 12e-3 / 1e9
    assert 1.05 < mean / 18.90 < 1.15


def test_number_of_slices_is_converged():
    pair = thick_rimmed_pair(12.0, 12)
    force = 87e3 * 12e-3
    curves = []
    for n in (15, 90):
        law = Plane(slices=n).law(pair, "drive")
        curves.append([loaded(law, c, force) for c in np.arange(32) / 32])
    assert np.mean(curves[0]) == pytest.approx(np.mean(curves[1]), rel=0.002)
    assert np.ptp(curves[0]) == pytest.approx(np.ptp(curves[1]), rel=0.02)


def test_slices_cover_the_face(helical):
    law = helical[0]
    assert law.slice_width.sum() == pytest.approx(12e-3, rel=1e-14)
    assert law.face_coordinate.mean() == pytest.approx(0.0, abs=1e-18)
    across = law.slice_width.size * (law.cycle_shift[1] - law.cycle_shift[0])
    assert abs(across) == pytest.approx(thick_rimmed_pair(12.0, 12).overlap_ratio, rel=1e-12)


@pytest.mark.parametrize("pinion", [gear(12), gear(250), gear(30, bore_mm=2)])
def test_undercut_large_and_thick_gears_are_meshed(pinion):
    mesh = sector_mesh(pinion)
    flank = ring.flank_compliance(mesh, YOUNG, POISSON)
    assert np.isfinite(flank.matrix[0]).all()
    assert np.diag(flank.matrix[0]).min() > 0


def test_bad_options_are_refused():
    with pytest.raises(ModelError, match="slices = 0: must be 1 to 101"):
        Plane(slices=0)
    with pytest.raises(ModelError, match="choose one of drive, coast"):
        Plane().law(thick_rimmed_pair(face_mm=30), "left")
