"""Rung `plane`: ring against published tooth compliances and a whole ring, contact split, limits of the law."""

import math

import numpy as np
import pytest
from rings import whole_ring_response
from scipy import sparse

from fem.contact.evaluation.evaluator import checked_teeth, evaluate, evaluate_shares, law_tables, share_reach
from fem.contact.models.plane import Plane, PlaneError
from fem.contact.teeth import tooth_terms
from fem.contact.wheels import ring
from fem.elements.sections import shape_functions
from fem.gears.geometry import Gear, GearPair
from fem.gears.sector import sector_mesh

YOUNG, POISSON = 206e9, 0.3


def gear(teeth, module=2e-3, beta=0.0, face=30e-3, hand="right", bore=None):
    """Standard gear; bore at r_f / 1.4 unless given."""
    root = (teeth / math.cos(beta) / 2 - 1.25) * module
    return Gear(
        teeth=teeth,
        normal_module=module,
        helix_angle=beta,
        face_width=face,
        hand=hand,
        bore_radius=root / 1.4 if bore is None else bore,
    )


def pair_of(beta_deg=0.0, face=30e-3):
    beta = math.radians(beta_deg)
    return GearPair(pinion=gear(20, beta=beta, face=face), wheel=gear(55, beta=beta, face=face, hand="left"))


@pytest.fixture(scope="module")
def spur():
    return Plane(slices=1).law(pair_of(), "drive")


@pytest.fixture(scope="module")
def helical():
    return Plane(slices=11).laws(pair_of(12.0, 12e-3))


def approach(law, line_load, xi=0.0):
    """Approach (m) of a single pair at the local position xi under a line load (N/m)."""
    at = law.position_start + law.position_step * np.arange(law.compliance.size)
    c, b = np.interp(xi, at, law.compliance), np.interp(xi, at, law.contact_offset)
    return c * line_load + law.contact_slope * line_load * (b - np.log(line_load))


def loaded(law, cycle, force, psi=0.0):
    """delta (m) at which the law carries `force` (N), by bisection."""
    tables, none = law_tables(law), checked_teeth(law, None, None)
    low, high = 0.0, 90e-6
    for _ in range(60):
        delta = (low + high) / 2
        low, high = (low, delta) if evaluate(tables, cycle, delta, psi, *none)[0] > force else (delta, high)
    return (low + high) / 2


# --- the ring ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("teeth", "beta_deg"), [(11, 0.0), (12, 20.0)])
def test_condensed_ring_equals_the_ring_meshed_as_a_whole(teeth, beta_deg):
    mesh = sector_mesh(gear(teeth, beta=math.radians(beta_deg)), refinement=0.5)
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
    g = gear(teeth, module=1e-3)
    mesh = sector_mesh(g, refinement=2.0)
    radius = radius / 1000
    arc = (radius**2 - g.base_radius**2) / (2 * g.base_radius)
    patches = ring.FlankCompliance(arc=mesh.flank_arc, tip_arc=mesh.tip_arc, matrix={})
    load = ring.flank_loads(mesh) @ patches.patches(np.array([arc]), 0.04e-3)[0].T
    inclination = g.pressure_angle_at(radius) - g.half_thickness_angle(radius)
    line = np.array([np.sin(inclination), np.cos(inclination)])  # out of the tooth
    seen = point_load(mesh, np.array([g.base_radius / np.cos(inclination), 0.0]), -line)
    both = sparse.csc_matrix(np.column_stack([load.ravel(), seen]))
    response = ring.ring_response(ring.reduce_sector(mesh, YOUNG, POISSON, both))
    assert response[0][1, 0] * 1e9 == pytest.approx(published, rel=0.005)


def point_load(mesh, place, direction):
    """Load vector of a unit force at an inner point."""
    for element in mesh.elements[np.argsort(np.linalg.norm(mesh.points[mesh.elements[:, 4]] - place, axis=1))[:20]]:
        local = np.zeros(2)
        for _ in range(20):
            values, slopes = shape_functions(np.clip(local, -2, 2)[None])
            corners = mesh.points[element]
            local = np.clip(local, -2, 2) - np.linalg.solve(corners.T @ slopes[0], values[0] @ corners - place)
        if abs(local).max() <= 1 + 1e-9:
            out = np.zeros((len(mesh.points), 2))
            out[element] = shape_functions(local[None])[0][0][:, None] * direction
            return out.ravel()
    raise AssertionError(f"{place} is not in the mesh")


@pytest.mark.parametrize("beta_deg", [0.0, 25.0])
def test_flank_compliances_are_reciprocal_and_positive(beta_deg):
    mesh = sector_mesh(gear(18, beta=math.radians(beta_deg)))
    flank = ring.flank_compliance(mesh, YOUNG, POISSON)
    for n in (0, 1, 2):
        assert abs(flank.matrix[n] - flank.matrix[-n].T).max() < 1e-11 * abs(flank.matrix[0]).max()
    weight, _ = flank.patches(np.linspace(mesh.form_arc, mesh.tip_arc, 7), 0.1e-3)
    teeth = range(-1, 2)
    whole = np.block([[weight @ flank.matrix[i - j] @ weight.T for j in teeth] for i in teeth])
    assert np.linalg.eigvalsh(whole)[0] > 0


def test_normal_loads_turn_the_gear_with_the_base_radius():
    for beta in (0.0, 0.4):
        g = gear(23, beta=beta)
        mesh = sector_mesh(g)
        loads = ring.flank_loads(mesh).toarray().reshape(len(mesh.points), -1, len(mesh.flank))
        moment = np.einsum("n,np->p", mesh.points[:, 0], loads[:, 1]) - np.einsum(
            "n,np->p", mesh.points[:, 1], loads[:, 0]
        )
        assert moment[mesh.flank_arc >= mesh.form_arc] == pytest.approx(-g.base_radius, rel=1e-12)
        if beta:
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
        assert load / approach(spur, load) / 1e9 == pytest.approx(truth, rel=0.005)


def test_result_is_independent_of_the_patch_and_of_the_mesh(spur):
    variants = [Plane(slices=1, refinement=2.0, patch=patch).law(pair_of(), "drive") for patch in (0.04, 0.08)]
    for xi in (-0.6, -0.3, 0.0, 0.3, 0.6):
        values = [approach(law, 100e3, xi) for law in (spur, *variants)]
        assert np.ptp(values) < 0.002 * values[0]


def test_compliance_converges_with_refinement():
    reference, *others = [
        approach(Plane(slices=1, refinement=r, patch=0.1).law(pair_of(), "drive"), 100e3) for r in (2.0, 0.5, 1.0)
    ]
    errors = [abs(value / reference - 1) for value in others]
    assert errors[0] < 0.005
    assert errors[1] < errors[0] / 3


def test_helical_approach_against_a_contact_solution_in_space():
    """17/43, m_n 1, beta 20, b 10 mm, T1 2 N m at c = 0.1325: approach normal to the flank 1.222 um (3-D contact FE).

    Straight-tooth plane strain in the transverse section would be 11 % too stiff.
    """
    beta = math.radians(20.0)
    pair = GearPair(
        pinion=gear(17, 1e-3, beta, 10e-3, bore=5.568e-3),
        wheel=gear(43, 1e-3, beta, 10e-3, "left", bore=15.450e-3),
        centre_distance=31.925333e-3,
    )
    force = 2.0 / pair.pinion.base_radius
    delta = loaded(Plane(slices=31).law(pair, "drive"), 0.1325, force)
    assert delta * math.cos(pair.base_helix_angle) == pytest.approx(1.222e-6, rel=0.03)
    assert force / delta == pytest.approx(183.7e6, rel=0.03)


# --- the law ----------------------------------------------------------------------------------------------------------


def test_no_helix_gives_the_spur_law(spur):
    nearly = Plane(slices=1).law(pair_of(0.01), "drive")
    assert nearly.compliance == pytest.approx(spur.compliance, rel=1e-4)
    assert nearly.coupling == pytest.approx(spur.coupling, rel=2e-4)
    assert nearly.contact_slope == pytest.approx(spur.contact_slope, rel=1e-6)


def test_stiffness_responds_to_the_helix(spur, helical):
    """c' falls with the helix angle as in ISO 6336-1, clause 9: cos(beta) / q'(z_n1, z_n2), z_n the virtual teeth."""

    def iso(beta_deg):
        pair = pair_of(beta_deg)
        flexibility = 0.04723 + 0.15551 / pair.pinion.virtual_teeth + 0.25791 / pair.wheel.virtual_teeth
        return math.cos(math.radians(beta_deg)) / flexibility

    for beta_deg, law in ((12.0, helical[0]), (25.0, Plane(slices=1).law(pair_of(25.0), "drive"))):
        found = approach(spur, 100e3) / approach(law, 100e3)
        assert found < 1
        assert found == pytest.approx(iso(beta_deg) / iso(0.0), rel=0.012)


def test_shares_sum_to_the_force_and_the_law_is_periodic(helical):
    law = helical[0]
    tables, none = law_tables(law), (tooth_terms(20), tooth_terms(55))
    for cycle in (0.0, 0.37, 0.81):
        share = np.zeros(2 * share_reach(law) + 1)
        force = evaluate_shares(tables, cycle, 6e-6, 1e-4, *none, share)[0]
        assert (share >= 0).all()
        assert share.sum() == pytest.approx(force, rel=1e-12)
        assert evaluate(tables, cycle + 3, 6e-6, 1e-4, *none)[0] == pytest.approx(force, rel=1e-9)


def test_coast_is_the_mirror_image_of_drive(helical):
    drive, coast = helical
    none = (tooth_terms(20), tooth_terms(55))
    for u in (0.1, 0.55):
        ahead = evaluate(law_tables(drive), u, 5e-6, 2e-4, *none)
        mirrored = evaluate(law_tables(coast), pair_of(12.0, 12e-3).thickness_cycle - u, 5e-6, -2e-4, *none)
        assert mirrored[0] == pytest.approx(ahead[0], rel=1e-9)
        assert mirrored[1] == pytest.approx(-ahead[1], rel=1e-9)
    assert (coast.cycle_sign, coast.wheel_tooth_offset) == (-1, 1)


def test_mean_stiffness_is_about_a_tenth_above_iso(helical):
    """ISO 6336-1 for 20/55, beta 12: c_gamma_alpha 18.90 N/(mm um) at 100 N/mm, which contains C_M = 0.8."""
    force = 100e3 * 12e-3
    mean = np.mean([force / loaded(helical[0], c, force) for c in np.arange(16) / 16]) / 12e-3 / 1e9
    assert 1.05 < mean / 18.90 < 1.15


def test_number_of_slices_is_converged():
    pair = pair_of(12.0, 12e-3)
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
    assert abs(across) == pytest.approx(pair_of(12.0, 12e-3).overlap_ratio, rel=1e-12)


@pytest.mark.parametrize("pinion", [gear(12, face=1e-2), gear(250, face=1e-2), gear(30, face=1e-2, bore=2e-3)])
def test_undercut_large_and_thick_gears_are_meshed(pinion):
    mesh = sector_mesh(pinion)
    flank = ring.flank_compliance(mesh, YOUNG, POISSON)
    assert np.isfinite(flank.matrix[0]).all()
    assert np.diag(flank.matrix[0]).min() > 0


def test_bad_options_are_refused():
    with pytest.raises(PlaneError, match="slices is 0"):
        Plane(slices=0)
    with pytest.raises(PlaneError, match="not resolved"):
        Plane(patch=0.02)
    with pytest.raises(PlaneError, match="'drive' or 'coast'"):
        Plane().law(pair_of(), "left")
