"""Rims on webs in model `solid`: empty parts of the prism, functions of the cuts, references in space, offset webs."""

from dataclasses import replace

import numpy as np
import pytest
from mesh_laws import potential_errors
from scipy import sparse

from benchmarks import gear_bodies
from benchmarks.gear_pairs import gear, gear_pair
from benchmarks.solid_contact import solve
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.models.solid import Solid
from fem.contact.models.solid_condensation import condense
from fem.contact.models.solid_stress import stress_field
from fem.contact.wheels.sector_face_functions import CutFunctions, piecewise
from fem.contact.wheels.solid_ring import sector_prism, solid_flank
from fem.contact.wheels.web_place import axial_ends, web_ends
from fem.elements.nested_condensation import INNER
from fem.elements.twisted_hexahedra import axial_matrices, slice_means
from fem.gears.sector_mesh import sector_mesh
from fem.numerics.linear_solver import factorize
from pipelines.machine.checks.design_warnings import design_warnings
from pipelines.machine.machine_conversion import make_drivetrain
from pipelines.scene.load_scene import load_scene

YOUNG, POISSON = 206e9, 0.3
ALL_NODES = CutFunctions(radial=None, axial=None)
ROWS = np.array([8, 12, 16])
QUICK = Solid(slices=5, refinement=0.6, positions=8)
LOAD = 100e3 * 12e-3


def webbed(helix=0.0, offset=3e-3, rim=4e-3, web=4e-3):
    return replace(gear(24, helix_deg=helix, bore_mm=10.0), rim_thickness=rim, web_thickness=web, web_offset=offset)


def flank(one, cut=None, elements=4, turn=1):
    web = web_ends(one, turn)
    ends = axial_ends(one.face_width, elements, web)
    return solid_flank(sector_mesh(one, 0.2), YOUNG, POISSON, ends, ROWS, 1, cut or CutFunctions(), web)


def webbed_pair(offset, helix=12.0):
    pair = gear_pair((20, 55), 2, helix, 12, bores_mm=(12.5, 17.5))
    wheel = replace(pair.wheel, rim_thickness=5e-3, web_thickness=4e-3, web_offset=offset)
    return replace(pair, wheel=wheel, centre_distance=None)


# --- one gear ---------------------------------------------------------------------------------------------------------


def test_axial_elements_end_where_the_web_ends():
    for web in ((-6e-3, -3e-3), (-1e-3, 2e-3), (3e-3, 6e-3)):
        ends = axial_ends(12e-3, 8, web)
        assert np.isin(web, ends).all()
        assert (np.diff(ends) > 0.3e-3).all()
        assert np.diff(ends).max() <= np.diff(axial_ends(12e-3, 8)).max() * 1.001
    assert axial_ends(12e-3, 8, None)[[0, 4, 8]] == pytest.approx([-6e-3, 0.0, 6e-3], abs=1e-18)


def test_piecewise_functions_hold_every_polynomial_of_their_parts_and_are_continuous():
    joints = np.array([0.0, 1.0, 3.0])
    place = np.linspace(0.0, 3.0, 31)
    functions = piecewise(place, joints, (3, 2))
    kinked = np.where(place < 1.0, place**3, 1.0 + 2 * (place - 1.0) ** 2)
    fit = functions @ np.linalg.lstsq(functions, kinked, rcond=None)[0]
    assert fit == pytest.approx(kinked, abs=1e-12)
    assert functions.shape[1] == np.linalg.matrix_rank(functions) == 3 + 2 + 1


def test_condensation_of_a_prism_with_empty_parts_equals_the_schur_complement_of_what_is_there():
    one = webbed(23.0, rim=3e-3)
    mesh, web = sector_mesh(one, 0.2), web_ends(one, 1)
    ends = np.array([-6e-3, web[0], web[1], 6e-3])
    prism = sector_prism(mesh, YOUNG, POISSON, ends, np.array([10, 14]), ALL_NODES, web)
    numbers, found = prism.condense()
    size = 3 * len(mesh.points)
    dofs = (3 * mesh.elements[:, :, None] + np.arange(3)).reshape(-1, 27)
    matrix = sparse.csr_matrix((size * 7, size * 7))
    for layer in range(3):
        here = prism.filled[:, layer]
        at = np.repeat(dofs[here], 27, axis=1).ravel(), np.tile(dofs[here], (1, 27)).ravel()
        plane, mixed, along = (
            sparse.csr_matrix((block[here].ravel(), at), shape=(size, size)) for block in prism.blocks
        )
        axial = axial_matrices(ends[layer : layer + 2])
        across = sparse.kron(axial[1], mixed)
        part = sparse.kron(axial[0], plane) + across + across.T + sparse.kron(axial[2], along)
        place = np.arange(3 * size) + 2 * layer * size
        spread = sparse.csr_matrix((np.ones(3 * size), (place, np.arange(3 * size))), shape=(7 * size, 3 * size))
        matrix = matrix + spread @ part @ spread.T
    there = matrix.diagonal() > 0
    roles = np.tile(prism.roles.ravel(), 7)
    inner, kept = np.flatnonzero(there & (roles == INNER)), numbers[numbers < prism.size]
    assert there[kept].all()
    # with the cuts held: what the loaded nodes see
    right = matrix[inner][:, kept].toarray()
    answer = factorize(matrix[inner][:, inner]).solve(right)
    schur = matrix[kept][:, kept].toarray() - right.T @ answer
    assert abs(found[: len(kept), : len(kept)] - schur).max() < 1e-9 * abs(schur).max()


def test_a_web_as_wide_as_the_face_is_the_solid_body():
    one = webbed(12.0, offset=0.0, web=12e-3)
    assert web_ends(one, 1) is None
    ends, mesh = axial_ends(one.face_width, 4), sector_mesh(one, 0.2)
    solid = solid_flank(mesh, YOUNG, POISSON, ends, ROWS, 1, ALL_NODES).matrix[0]
    filled = solid_flank(mesh, YOUNG, POISSON, ends, ROWS, 1, ALL_NODES, (-6e-3, 6e-3)).matrix[0]
    assert abs(filled - solid).max() < 1e-9 * abs(solid).max()


@pytest.mark.parametrize("one", [webbed(12.0, offset=4e-3), webbed(0.0, offset=0.0, rim=2.4e-3)], ids=["end", "thin"])
def test_functions_of_rim_and_web_do_for_all_nodes_of_the_cuts(one):
    full, error = flank(one, ALL_NODES).matrix, {}
    for degree in (2, CutFunctions().along):
        few = flank(one, CutFunctions(rim=degree, web=degree, along=degree)).matrix
        error[degree] = max(abs(few[n] - full[n]).max() for n in (0, 1)) / full[0].max()
        assert np.linalg.eigvalsh(full[0] - few[0])[0] > -1e-6 * full[0].max()  # a tie can only stiffen
    assert error[CutFunctions().along] < 3e-4 < error[2]


def test_mirrored_web_mirrors_the_compliance_of_straight_teeth():
    there, here = (flank(webbed(offset=offset)).matrix[0] for offset in (3e-3, -3e-3))
    along = len(here) // 3
    there, here = there.reshape(3, along, 3, along), here.reshape(3, along, 3, along)
    assert abs(there - here[:, ::-1, :, ::-1]).max() < 1e-9 * abs(here).max()
    ends = axial_ends(12e-3, 4, (1e-3, 5e-3))
    far, over = slice_means(ends, np.array([-6e-3, -4e-3, 4e-3, 6e-3]))[[0, 2]]
    assert far @ there[1, :, 1] @ far > 1.15 * over @ there[1, :, 1] @ over


@pytest.mark.slow
@pytest.mark.parametrize("body", gear_bodies.BODIES, ids=lambda body: body.name)
def test_deflection_at_six_places_against_tetrahedra(body):
    """The compliances between all places, from the bore, by the finer of two meshes of the whole gear."""
    assert abs(gear_bodies.by_sector(body, 0.8) / gear_bodies.reference(body) - 1.0).max() < 0.03


# --- a pair -----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def drive():
    return QUICK.compliance(webbed_pair(4e-3))


def test_an_offset_web_gives_every_flank_its_own_compliances(drive):
    assert drive.flank == 1
    assert QUICK.compliance(webbed_pair(4e-3), "coast").flank == -1


@pytest.mark.slow
def test_mirrored_web_mirrors_the_law():
    """Half a turn about a radial axis: the coast flank of one is the drive flank of the other, seen from behind.

    In the mean of both, from which the thrust of the helix drops out, level flanks carry more where the web stands.
    """
    drive, coast = QUICK.laws(webbed_pair(4e-3))
    level = [LawEvaluator(law).evaluate(0.3, 20e-6, 0.0) for law in (drive, coast)]
    assert sum(float(at.moment / at.force) for at in level) / 2 > 0.3e-3
    mirrored = QUICK.law(webbed_pair(-4e-3), "drive")
    assert mirrored.skew_compliance == pytest.approx(-coast.skew_compliance, rel=1e-9)
    assert mirrored.compliance == pytest.approx(coast.compliance, rel=1e-9)
    assert abs(drive.compliance / coast.compliance - 1.0).max() > 0.01


def test_the_law_of_an_offset_web_is_one_convex_potential(drive):
    law = condense(drive, webbed_pair(4e-3), "drive", QUICK.plane)
    assert law.compliance.min() > 0
    body = np.array([[law.body_compliance, law.skew_compliance], [law.skew_compliance, law.tilt_compliance]])
    assert np.linalg.eigvalsh(body / np.outer([1, 6e-3], [1, 6e-3]))[0] >= 0
    draw = np.random.default_rng(3)
    states = draw.uniform(-30, 30, 40), draw.uniform(0.0, 5e-5, 40), draw.normal(0, 3e-4, 40)
    assert ((potential_errors(law, states) <= 1e-5).mean(axis=1) >= 0.9).all()
    other = LawEvaluator(law).evaluate(states[0], states[1][::-1], states[2][::-1]).energy
    middle = LawEvaluator(law).evaluate(states[0], (states[1] + states[1][::-1]) / 2, (states[2] + states[2][::-1]) / 2)
    here = LawEvaluator(law).evaluate(*states).energy
    assert (middle.energy <= (here + other) / 2 * (1 + 1e-9)).all()


def test_the_law_keeps_mean_stiffness_of_the_direct_solution(drive):
    law = condense(drive, webbed_pair(4e-3), "drive", QUICK.plane)
    found = stiffness_curve(law, LOAD, drive.position).secant.mean()
    assert found == pytest.approx((LOAD / solve(drive, force=LOAD).approach).mean(), rel=0.01)


def test_stress_field_has_no_cells_where_there_is_no_web(drive):
    pair = webbed_pair(4e-3)
    state = solve(drive, np.array([2]), force=LOAD)
    field = stress_field(pair, QUICK, drive, 2, state.line_load[0])[1]
    middle = field.points[0][field.cells].mean(axis=1)
    below = np.hypot(middle[:, 0], middle[:, 1]) < pair.wheel.rim_inner_radius
    assert below.any()
    # the wheel's axis runs against zeta, here against y: its web stands at -4 mm
    assert (middle[below, 2].min() > -6e-3) & (middle[below, 2].max() < -2e-3)
    assert np.isfinite(field.von_mises).all()
    assert field.von_mises.max() < 5 * 100e3 / 2e-3


def test_models_of_the_plane_say_that_they_ignore_the_offset():
    web = ("rim_thickness_mm=5", "web_thickness_mm=4", "web_offset_mm=3")
    settings = tuple(f"stages.1.wheel.{key}" for key in web)
    for model, told in (("plane", True), ("solid", False)):
        scene = load_scene("minimal", (*settings, f"stages.1.mesh.model={model}")).scene
        assert any("web_offset_mm" in text for text in design_warnings(scene, make_drivetrain(scene))) == told
