"""Solid elements against exact solutions and the forms of scikit-fem; linear solvers."""

import itertools
from math import factorial

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp

from benchmarks.solids import box_mesh, unknowns
from fem.elements.solid_elements import (
    CHOICES,
    CURVED_RULE,
    SOLIDS,
    STRAIGHT_RULE,
    ElementError,
    curved,
    rule,
    shapes,
    solid_mesh,
)
from fem.elements.solids import assemble, lame, mass_properties, rigid_body_modes
from fem.numerics.elimination import plan_elimination
from fem.numerics.linear_solver import SingularMatrixError, factorize

STEEL = {"elastic_modulus": 2.0e11, "poisson_ratio": 0.3, "density": 7800.0}


def bent(nodes, inner=1.0):
    """A box (0..1, 0..angle, 0..1) bent into a sector of a ring: curved elements."""
    r, angle, z = nodes.T
    return np.column_stack([(inner + r) * np.cos(angle), (inner + r) * np.sin(angle), z])


def test_quadrature_on_tetrahedra_is_exact_to_degree_eight_where_they_are_curved_and_two_where_not():
    """int x^a y^b z^c over the unit tetrahedron = a! b! c! / (a + b + c + 3)!"""
    for degree, exact_to in ((STRAIGHT_RULE, 2), (CURVED_RULE, 8)):
        (x, y, z), weights = rule(SOLIDS["tetrahedron-10"].library, degree)
        for a, b, c in itertools.product(range(exact_to + 1), repeat=3):
            if a + b + c <= exact_to:
                exact = factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3)
                assert weights @ (x**a * y**b * z**c) == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("name", SOLIDS)
def test_shape_functions_are_one_at_their_node_form_a_partition_of_unity_and_match_their_gradients(name):
    library = SOLIDS[name].library
    assert np.allclose(shapes(library, library.doflocs.T)[0], np.eye(SOLIDS[name].nodes), atol=1e-14)
    points, _ = rule(library, 4)
    assert np.allclose(shapes(library, points)[0].sum(axis=1), 1.0, atol=1e-14)
    step = 1e-6
    for axis in range(3):
        shift = step * np.eye(3)[:, [axis]]
        difference = (shapes(library, points + shift)[0] - shapes(library, points - shift)[0]) / (2 * step)
        assert np.allclose(shapes(library, points)[1][:, :, axis], difference, atol=1e-8)


@pytest.mark.parametrize("element", CHOICES)
def test_constant_strain_is_exact_on_a_distorted_mesh(element):
    nodes, elements = box_mesh((1.0, 0.8, 0.6), (3, 3, 3), element=element, distortion=0.3)
    K, _ = assemble(nodes, elements, **STEEL)
    gradient = np.random.default_rng(1).standard_normal((3, 3)) * 1e-3
    exact = (nodes @ gradient.T).ravel()
    on_surface = ((nodes == 0) | np.isclose(nodes, (1.0, 0.8, 0.6))).any(axis=1)
    held, free = unknowns(np.flatnonzero(on_surface)), unknowns(np.flatnonzero(~on_surface))
    found = factorize(K[free][:, free]).solve(-(K[free][:, held] @ exact[held]))
    assert np.abs(found - exact[free]).max() < 1e-12 * np.abs(exact).max()
    lam, mu = lame(STEEL["elastic_modulus"], STEEL["poisson_ratio"])
    strain = 0.5 * (gradient + gradient.T)
    energy = 0.48 * (0.5 * lam * np.trace(strain) ** 2 + mu * (strain**2).sum())
    assert 0.5 * exact @ K @ exact == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("element", CHOICES)
@pytest.mark.parametrize("shape", ["distorted", "curved"])
def test_exactly_six_motions_need_no_force(shape, element):
    distortion = 0.3 if shape == "distorted" else 0.0
    nodes, elements = box_mesh((1.0, 1.0, 1.0), (2, 2, 2), element=element, distortion=distortion)
    nodes = bent(nodes) if shape == "curved" else nodes
    K, _ = assemble(nodes, elements, **STEEL)
    value = la.eigvalsh(K.toarray())
    assert np.abs(value[:6]).max() < 1e-11 * value[-1] < 1e-6 * value[6]
    R = rigid_body_modes(nodes)
    assert np.abs(K @ R).max() < 1e-13 * np.abs(K).max() * np.abs(R).max() * 100


@pytest.mark.parametrize("element", CHOICES)
def test_mass_centre_and_inertia_of_a_box_are_exact(element):
    size = np.array([1.0, 0.8, 0.6])
    nodes, elements = box_mesh(size, (2, 3, 2), element=element, distortion=0.3)
    mass, centre, inertia = mass_properties(nodes + [3.0, -1.0, 2.0], elements, 7800.0)
    exact = 7800.0 * size.prod()
    assert mass == pytest.approx(exact, rel=1e-13)
    assert np.allclose(centre, size / 2 + [3.0, -1.0, 2.0], rtol=1e-12)
    assert np.allclose(inertia, exact / 12 * np.diag((size**2).sum() - size**2), atol=1e-10 * exact)
    _, M = assemble(nodes, elements, **STEEL)
    R = rigid_body_modes(nodes, size / 2)
    assert np.allclose(R.T @ M @ R, la.block_diag(exact * np.eye(3), inertia), atol=1e-10 * exact)


@pytest.mark.parametrize("element", [name for name in CHOICES if SOLIDS[name].degree == 2])
def test_curved_elements_meet_the_volume_of_a_ring_at_fourth_order(element):
    errors = []
    for n in (2, 4):
        nodes, elements = box_mesh((1.0, 1.0, 1.0), (1, n, 1), element=element)
        nodes = bent(nodes)
        assert curved(nodes, elements).all()
        errors.append(abs(mass_properties(nodes, elements, 1.0)[0] / 1.5 - 1.0))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize("element", CHOICES)
def test_matrices_agree_with_the_vector_valued_forms_of_scikit_fem(element):
    """Straight elements: curved ones would need the same rule there."""
    from skfem import Basis, BilinearForm, ElementVector
    from skfem.helpers import dot
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    nodes, elements = box_mesh((1.0, 0.8, 0.6), (2, 2, 2), element=element, distortion=0.3)
    degree = 4 if element.startswith("tetrahedron") else 5
    basis = Basis(solid_mesh(nodes, elements), ElementVector(SOLIDS[element].library), intorder=degree)
    form = linear_elasticity(*lame_parameters(STEEL["elastic_modulus"], STEEL["poisson_ratio"]))
    theirs = form.assemble(basis), BilinearForm(lambda u, v, w: 7800.0 * dot(u, v)).assemble(basis)
    place = {tuple(np.round(point, 9)): node for node, point in enumerate(nodes)}
    scalar = np.array([place[tuple(np.round(point, 9))] for point in basis.doflocs.T])
    order = 3 * scalar  # and which component each of their unknowns belongs to: the three of a place follow in order
    for node in range(len(nodes)):
        order[np.flatnonzero(scalar == node)] += np.arange(3)
    for ours, other in zip(assemble(nodes, elements, **STEEL), theirs, strict=True):
        assert abs(ours[order][:, order] - other).max() < 1e-12 * abs(other).max()


def test_cantilever_frequency_meets_beam_theory():
    """First bending mode of a slender beam, Euler and Bernoulli with Rayleigh's rotary inertia; nu = 0."""
    length, depth, width = 3.0, 0.1, 0.14
    nodes, elements = box_mesh((length, depth, width), (24, 1, 1))
    K, M = assemble(nodes, elements, elastic_modulus=2.0e11, poisson_ratio=0.0, density=7800.0)
    free = unknowns(np.flatnonzero(nodes[:, 0] > 0))
    from scipy.sparse.linalg import eigsh

    omega = np.sqrt(eigsh(K[free][:, free], 1, M[free][:, free], sigma=0.0, return_eigenvectors=False)[0])
    theory = 1.8751041**2 * np.sqrt(2.0e11 * depth**2 / 12 / 7800.0) / length**2
    assert omega == pytest.approx(theory, rel=2e-3)


def test_inverted_elements_and_loose_nodes_are_refused_with_their_place():
    nodes, elements = box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    swapped = elements.copy()
    swapped[2, [0, 1]] = swapped[2, [1, 0]]
    with pytest.raises(ElementError, match=r"inverted.*element 2 near"):
        assemble(nodes, swapped, **STEEL)
    with pytest.raises(ElementError, match="1 nodes belong to no element"):
        assemble(np.vstack([nodes, [5.0, 5.0, 5.0]]), elements, **STEEL)


@pytest.fixture(scope="module")
def block():
    nodes, elements = box_mesh((1.0, 1.0, 1.0), (3, 3, 3))
    K, M = assemble(nodes, elements, **STEEL)
    free = unknowns(np.flatnonzero(nodes[:, 2] > 0))
    return K, M, free


class TestLinearSolver:
    def test_many_right_sides(self, block):
        K, _, free = block
        matrix = K[free][:, free]
        X = np.random.default_rng(0).standard_normal((len(free), 5))
        B = matrix @ X
        kept = B.copy()
        factor = factorize(matrix)
        assert np.allclose(factor.solve(B), X, rtol=0, atol=1e-9)
        assert factor.solve(B[:, 0]).shape == (len(free),)
        assert np.array_equal(B, kept)

    def test_a_free_body_is_refused(self, block):
        with pytest.raises(SingularMatrixError, match="not positive definite"):
            factorize(block[0])

    def test_an_indefinite_matrix_is_refused(self, block):
        K, M, free = block
        shifted = K - 1e9 * M  # beyond some eigenvalues of the clamped block
        with pytest.raises(SingularMatrixError, match="negative"):
            factorize(shifted[free][:, free])

    def test_a_loose_part_is_refused(self, block):
        K, _, free = block
        with pytest.raises(SingularMatrixError):
            factorize(sp.block_diag([K[free][:, free], K]))


def test_not_square_and_not_finite_matrices_are_refused():
    with pytest.raises(ValueError, match="square"):
        factorize(sp.csr_matrix((2, 3)))
    with pytest.raises(ValueError, match="not finite"):
        factorize(sp.csr_matrix(np.array([[1.0, 0.0], [0.0, np.nan]])))


def test_nested_dissection_is_a_permutation_that_keeps_nodes_together(block):
    order = plan_elimination(block[0], 3).order
    assert np.array_equal(np.sort(order), np.arange(block[0].shape[0]))
    assert np.array_equal(order.reshape(-1, 3) // 3, np.repeat(order[::3, None] // 3, 3, axis=1))
