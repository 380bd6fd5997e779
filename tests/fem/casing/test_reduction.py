"""Craig-Bampton reduction: a published superelement run, plates with known frequencies, and what must always hold."""

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp

from benchmarks.checks.structures import (
    PLATE,
    cantilever_plate,
    craig_bampton,
    free_plate,
    full_bar,
    hertz,
    planar_bar,
    plate_frequencies,
    tapered_membrane,
    two_part_bar,
)
from benchmarks.solids import box_mesh, facets_on, unknowns
from fem.casing.reduced.attachment import AttachmentError, mean_motion_rows, nearest_surface_point
from fem.casing.reduced.lanczos import block_lanczos
from fem.casing.reduced.reduction import ReductionError, held_interface, reduce_body
from fem.elements.solids import assemble, rigid_body_modes
from fem.numerics.linear_solver import factorize

IRON = {"elastic_modulus": 1.1e11, "poisson_ratio": 0.26, "density": 7200.0}


# Hz, MSC Nastran superelement run published in vtpasquale/NASTRAN_CoFE, model cantilever_bar
COFE_FULL = [349.7288, 2167.324, 6007.803, 11650.23, 19044.54, 28065.27]
COFE = {
    0: [359.0738, 2934.100],
    1: [349.7555, 2182.490, 6733.634, 18222.00],
    2: [349.7299, 2168.126, 6011.365, 11851.45, 21809.58, 48160.41],
    3: [349.7289, 2167.436, 6008.068, 11670.88, 19073.61, 28653.90],
}


def test_full_bar_agrees_with_the_published_run():
    assert full_bar() == pytest.approx(COFE_FULL, rel=1e-5)


@pytest.mark.parametrize("n_modes", [0, 1, 2, 3])
def test_two_part_bar_agrees_with_the_published_run(n_modes):
    published = COFE[n_modes]
    assert two_part_bar(n_modes, len(published)) == pytest.approx(published, rel=1e-5)


class Bar:
    """A clamped bar of solid elements with two mean-motion patches: large enough for the iterative eigensolver."""

    def __init__(self):
        self.nodes, self.elements = box_mesh((0.4, 0.06, 0.05), (8, 2, 2), distortion=0.2)
        K, M = assemble(self.nodes, self.elements, **IRON)
        self.free = unknowns(np.flatnonzero(self.nodes[:, 0] > 0))
        self.K, self.M = K[self.free][:, self.free], M[self.free][:, self.free]
        end = facets_on(self.nodes, self.elements, self.nodes[:, 0] > 0.4 - 1e-9)
        top = facets_on(self.nodes, self.elements, (self.nodes[:, 2] > 0.05 - 1e-9) & (self.nodes[:, 0] < 0.2))
        self.patches = [(end, np.array([0.4, 0.03, 0.025])), (top, np.array([0.1, 0.03, 0.05]))]
        rows = [mean_motion_rows(self.nodes, *patch)[[0, 1, 2, 3, 5]] for patch in self.patches]
        self.rows = sp.vstack(rows, format="csr")[:, self.free]
        self.held = held_interface(self.K, self.rows)
        self.full = hertz(self.K.toarray(), self.M.toarray())

    def reduced(self, **options):
        return reduce_body(self.held, self.K, self.M, **options)


@pytest.fixture(scope="module")
def bar():
    return Bar()


def test_constraint_modes_move_one_interface_coordinate_each(bar):
    assert np.allclose(bar.rows @ bar.held.constraint, np.eye(10), atol=1e-10)


def test_reduced_matrices_are_the_projected_ones(bar):
    reduction = bar.reduced(highest=20000.0)
    assert reduction.n_fixed > 5
    for matrix, full in ((reduction.stiffness, bar.K), (reduction.mass, bar.M)):
        projected = reduction.basis.T @ (full @ reduction.basis)
        root = np.sqrt(np.diag(projected))
        assert np.abs((matrix - projected) / np.outer(root, root)).max() < 1e-6  # modes have a residual of 1e-5
    assert np.abs(bar.rows @ reduction.modes).max() < 1e-9 * np.abs(reduction.modes).max()


@pytest.mark.parametrize("enrich", [False, True])
def test_static_interface_response_is_exact(bar, enrich):
    reduction = bar.reduced(count=3, enrich=enrich)
    exact = bar.rows @ factorize(bar.K).solve(bar.rows.T.toarray())
    found = la.inv(reduction.stiffness)[:10, :10]
    root = np.sqrt(np.diag(exact))
    assert np.abs((found - exact) / np.outer(root, root)).max() < 1e-9


def test_no_modes_means_guyan(bar):
    """On plain unknowns, against the textbook partition formula."""
    keep = np.arange(0, 30, 7)
    rest = np.setdiff1d(np.arange(bar.K.shape[0]), keep)
    reduction = craig_bampton(bar.K, bar.M, keep, 0)
    K, M = bar.K.toarray(), bar.M.toarray()
    T = np.zeros((len(K), len(keep)))
    T[keep], T[rest] = np.eye(len(keep)), -la.solve(K[np.ix_(rest, rest)], K[np.ix_(rest, keep)])
    assert np.allclose(reduction.stiffness, T.T @ K @ T, rtol=1e-7, atol=1e-9 * np.abs(K).max())
    assert np.allclose(reduction.mass, T.T @ M @ T, rtol=1e-7, atol=1e-9 * np.abs(M).max())


def test_frequencies_come_from_above_and_fall_with_more_modes(bar):
    found = [hertz(r.stiffness, r.mass)[:6] for r in (bar.reduced(count=n, enrich=False) for n in (0, 2, 4, 8, 16))]
    assert (np.diff(found, axis=0) <= 1e-6).all()
    assert (found[-1] >= bar.full[:6] * (1 - 1e-9)).all()
    assert found[0][3] > 1.01 * found[-1][3]


def test_inertia_correction_lowers_the_error(bar):
    band = 0.6 * bar.full[14]
    kept = int((bar.full < band).sum())
    plain, enriched = (
        hertz(r.stiffness, r.mass)[:kept] / bar.full[:kept] - 1
        for r in (bar.reduced(highest=1.5 * band, enrich=e) for e in (False, True))
    )
    assert kept >= 4
    assert enriched.max() < 1e-4
    assert enriched.max() < 0.1 * plain.max()


def test_the_inertia_correction_adds_nothing_to_a_complete_set_of_modes():
    """Three masses in a row, the last one the interface: two modes are all there are."""
    K = sp.diags_array([[2000.0, 2000.0, 1000.0], [-1000.0] * 2, [-1000.0] * 2], offsets=[0, 1, -1], format="csr")
    reduction = craig_bampton(K, sp.eye_array(3, format="csr"), np.array([2]), 2, enrich=True)
    assert reduction.stiffness.shape == (3, 3)
    exact = 2 * np.sqrt(1000.0) * np.sin(np.array([1, 3, 5]) * np.pi / 14) / (2 * np.pi)
    assert hertz(reduction.stiffness, reduction.mass) == pytest.approx(exact, rel=1e-12)


def test_all_modes_below_the_limit_are_found(bar):
    """Block Lanczos against the dense eigensolution, double frequencies of a square bar included."""
    nodes, elements = box_mesh((0.5, 0.05, 0.05), (8, 2, 2))
    K, M = assemble(nodes, elements, **IRON)
    free = unknowns(np.flatnonzero(nodes[:, 0] > 0))
    K, M = K[free][:, free], M[free][:, free]
    full = hertz(K.toarray(), M.toarray())
    limit = full[40] * 1.0001
    theta, modes = block_lanczos(factorize(K).solve, M, smallest=(2 * np.pi * limit) ** -2)
    assert 1 / (2 * np.pi * np.sqrt(theta)) == pytest.approx(full[:41], rel=1e-9)
    assert np.allclose(modes.T @ (M @ modes), np.eye(41), atol=1e-10)
    by_count, _ = block_lanczos(factorize(K).solve, M, count=7)
    assert by_count == pytest.approx(theta[:7], rel=1e-9)


def test_modes_that_take_many_blocks_of_vectors_are_those_of_a_known_spectrum():
    """Unit masses on springs of 1, 4, 9, ... N/m: theta = 1/k^2."""
    stiffness = np.arange(1.0, 601.0) ** 2
    theta, modes = block_lanczos(lambda b: b / stiffness[:, None], sp.eye_array(600, format="csr"), count=120)
    assert theta == pytest.approx(1 / stiffness[:120], rel=1e-9)
    assert np.abs(modes).max(axis=0) == pytest.approx(1.0)


def test_dependent_interface_rows_are_refused(bar):
    with pytest.raises(ReductionError, match="not independent"):
        held_interface(bar.K, sp.vstack([bar.rows, bar.rows[:1]]))


def test_more_modes_than_masses_are_refused():
    K, M = planar_bar(5)
    with pytest.raises(ReductionError, match="only 4 have mass"):
        craig_bampton(sp.csr_matrix(K[2:, 2:]), sp.csr_matrix(M[2:, 2:]), np.array([8, 9]), 5)


def test_mean_motion_reproduces_rigid_motions_and_resultants(bar):
    for facets, centre in bar.patches:
        rows = mean_motion_rows(bar.nodes, facets, centre)
        R = rigid_body_modes(bar.nodes, centre)
        assert np.allclose(rows @ R, np.eye(6), atol=1e-10)  # also: unit loads have unit resultants, R^T B^T = 1


def test_mean_motion_weighs_by_area():
    """The mean of a quadratic field over a flat patch, against its integral."""
    nodes, elements = box_mesh((1.0, 2.0, 1.0), (2, 3, 1), distortion=0.0)
    facets = facets_on(nodes, elements, nodes[:, 2] > 1 - 1e-9)
    rows = mean_motion_rows(nodes, facets, np.array([0.5, 1.0, 1.0]))
    field = np.zeros_like(nodes)
    field[:, 2] = nodes[:, 0] ** 2
    assert (rows @ field.ravel())[2] == pytest.approx(1 / 3, rel=1e-12)


def test_sensor_point_is_the_nearest_of_the_surface(bar):
    facets = facets_on(bar.nodes, bar.elements, (np.abs(bar.nodes - [0.2, 0.03, 0.025]) > 0).any(axis=1))
    corners, weights, point = nearest_surface_point(bar.nodes, bar.patches[1][0], np.array([0.111, 0.017, 0.06]))
    assert point == pytest.approx([0.111, 0.017, 0.05])
    assert weights @ bar.nodes[corners] == pytest.approx(point)
    assert weights.sum() == pytest.approx(1.0)
    beyond = nearest_surface_point(bar.nodes, bar.patches[0][0], np.array([0.41, 0.07, 0.07]))[2]
    assert beyond == pytest.approx([0.4, 0.06, 0.05])  # the corner
    words = r"sensor at \(1000, 30, 25\) mm is 600 mm from the nearest .* at \(400, 30, 25\) mm"
    with pytest.raises(AttachmentError, match=words):
        nearest_surface_point(bar.nodes, facets, np.array([1.0, 0.03, 0.025]))


# plates of The Standard NAFEMS Benchmarks, free vibration


def simply_supported(n):
    """Held vertically along the middle lines of its edges."""
    nodes, elements = box_mesh((10.0, 10.0, 0.05), (n, n, 2))
    x, y, z = nodes.T
    edge = np.isclose(x, 0) | np.isclose(x, 10) | np.isclose(y, 0) | np.isclose(y, 10)
    middle = np.isclose(z, 0.025)
    corner = middle & np.isclose(y, 0)
    held = [3 * np.flatnonzero(edge & middle) + 2, 3 * np.flatnonzero(corner & np.isclose(x, 0))]
    held += [3 * np.flatnonzero(corner & (np.isclose(x, 0) | np.isclose(x, 10))) + 1]
    return plate_frequencies(nodes, elements, np.unique(np.concatenate(held)), 6)


def agrees_within_a_percent_and_converges(plate, refinements, published):
    """From above, every halving of the elements changes the frequencies by at most half of the change before."""
    coarse, middle, fine = (plate(n) for n in refinements)
    assert fine == pytest.approx(published, rel=0.01)
    assert (middle >= fine).all()
    assert (middle - fine < 0.5 * (coarse - middle)).all()


@pytest.mark.slow
def test_nafems_fv16_thin_cantilever_plate():
    agrees_within_a_percent_and_converges(cantilever_plate, (10, 20, 40), [0.421, 1.029, 2.582, 3.306, 3.753, 6.555])


@pytest.mark.slow
def test_simply_supported_thin_plate_converges():
    """The series of Navier for a thin plate."""
    expected = [2.377, 5.942, 5.942, 9.507, 11.884, 11.884]
    agrees_within_a_percent_and_converges(simply_supported, (10, 20, 40), expected)


@pytest.mark.slow
def test_nafems_free_thin_plate():
    agrees_within_a_percent_and_converges(free_plate, (10, 20, 40), [1.624, 2.383, 2.942, 4.217, 4.217])


@pytest.mark.slow
def test_nafems_fv32_tapered_membrane():
    expected = [44.623, 130.03, 162.70, 246.05, 379.90, 391.44]
    agrees_within_a_percent_and_converges(tapered_membrane, (4, 8, 16), expected)


def test_nafems_fv52_in_plane_modes_of_a_thick_plate():
    nodes, elements = box_mesh((10.0, 10.0, 1.0), (8, 8, 1))
    x, y, z = nodes.T
    edge = np.isclose(x, 0) | np.isclose(x, 10) | np.isclose(y, 0) | np.isclose(y, 10)
    held = 3 * np.flatnonzero(edge & np.isclose(z, 0)) + 2
    # free to slide in its plane: three rigid motions, then bending modes; in-plane ones found by their motion
    K, M = assemble(nodes, elements, **PLATE)
    free = np.setdiff1d(np.arange(len(nodes) * 3), held)
    shift = (2 * np.pi * 50.0) ** 2
    K, M = K[free][:, free], M[free][:, free]
    theta, modes = block_lanczos(factorize((K + shift * M).tocsr(), block=1).solve, M, count=14)
    frequency = np.sqrt(np.maximum(1 / theta - shift, 0)) / (2 * np.pi)
    vertical = free % 3 == 2
    share = np.einsum("ij,ij->j", modes[vertical], (M @ modes)[vertical])
    in_plane = frequency[(share < 0.1) & (frequency > 1.0)]
    assert in_plane[:3] == pytest.approx([193.59, 206.19, 206.19], rel=0.01)
