"""Quadratic tetrahedra against exact solutions, convergence theory and scikit-fem; linear solvers."""

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp

from benchmarks.solids import box_mesh, unknowns
from fem.elements.tetrahedra import (
    ElementError,
    assemble,
    conical_rule,
    curved,
    lame,
    mass_properties,
    rigid_body_modes,
    shape_gradients,
    shape_values,
)
from fem.numerics.linear_solver import SingularMatrixError, cholmod_available, factorize, nested_dissection

STEEL = {"elastic_modulus": 2.0e11, "poisson_ratio": 0.3, "density": 7800.0}
SOLVERS = [
    "multifrontal",
    "superlu",
    pytest.param("cholmod", marks=pytest.mark.skipif(not cholmod_available(), reason="optional")),
]


def bent(nodes, inner=1.0):
    """A box (0..1, 0..angle, 0..1) bent into a sector of a ring: curved elements."""
    r, angle, z = nodes.T
    return np.column_stack([(inner + r) * np.cos(angle), (inner + r) * np.sin(angle), z])


def test_quadrature_is_exact_to_its_degree():
    points, weights = conical_rule(4)
    x, y, z = points.T
    # int x^a y^b z^c over the unit tetrahedron = a! b! c! / (a + b + c + 3)!
    assert weights @ (x**3 * y**2 * z**2) == pytest.approx(6 * 2 * 2 / 3628800, rel=1e-12)


def test_shape_functions_form_a_partition_of_unity_with_matching_gradients():
    points = conical_rule(3)[0]
    assert np.allclose(shape_values(points).sum(axis=1), 1.0, atol=1e-14)
    step = 1e-6
    for axis in range(3):
        shift = step * np.eye(3)[axis]
        difference = (shape_values(points + shift) - shape_values(points - shift)) / (2 * step)
        assert np.allclose(shape_gradients(points)[:, :, axis], difference, atol=1e-8)


def test_constant_strain_is_exact_on_a_distorted_mesh():
    nodes, elements = box_mesh((1.0, 0.8, 0.6), (3, 3, 3), distortion=0.3)
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


@pytest.mark.parametrize("shape", ["distorted", "curved"])
def test_exactly_six_motions_need_no_force(shape):
    nodes, elements = box_mesh((1.0, 1.0, 1.0), (2, 2, 2), distortion=0.3 if shape == "distorted" else 0.0)
    nodes = bent(nodes) if shape == "curved" else nodes
    K, _ = assemble(nodes, elements, **STEEL)
    value = la.eigvalsh(K.toarray())
    assert np.abs(value[:6]).max() < 1e-11 * value[-1] < 1e-6 * value[6]
    R = rigid_body_modes(nodes)
    assert np.abs(K @ R).max() < 1e-13 * np.abs(K).max() * np.abs(R).max() * 100


def test_mass_centre_and_inertia_of_a_box_are_exact():
    size = np.array([1.0, 0.8, 0.6])
    nodes, elements = box_mesh(size, (2, 3, 2), distortion=0.3)
    mass, centre, inertia = mass_properties(nodes + [3.0, -1.0, 2.0], elements, 7800.0)
    exact = 7800.0 * size.prod()
    assert mass == pytest.approx(exact, rel=1e-13)
    assert np.allclose(centre, size / 2 + [3.0, -1.0, 2.0], rtol=1e-12)
    assert np.allclose(inertia, exact / 12 * np.diag((size**2).sum() - size**2), atol=1e-10 * exact)
    _, M = assemble(nodes, elements, **STEEL)
    R = rigid_body_modes(nodes, size / 2)
    assert np.allclose(R.T @ M @ R, la.block_diag(exact * np.eye(3), inertia), atol=1e-10 * exact)


def test_curved_elements_meet_the_volume_of_a_ring_at_fourth_order():
    errors = []
    for n in (2, 4):
        nodes, elements = box_mesh((1.0, 1.0, 1.0), (1, n, 1))
        nodes = bent(nodes)
        assert curved(nodes, elements).all()
        errors.append(abs(mass_properties(nodes, elements, 1.0)[0] / 1.5 - 1.0))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)


def test_matrices_agree_with_scikit_fem():
    from skfem import Basis, BilinearForm, ElementTetP2, ElementVector, MeshTet
    from skfem.helpers import dot
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    nodes, elements = box_mesh((1.0, 0.8, 0.6), (2, 2, 2), distortion=0.3)
    corners = int(elements[:, :4].max()) + 1
    basis = Basis(MeshTet(nodes[:corners].T, elements[:, :4].T), ElementVector(ElementTetP2()), intorder=4)
    form = linear_elasticity(*lame_parameters(STEEL["elastic_modulus"], STEEL["poisson_ratio"]))
    theirs = form.assemble(basis), BilinearForm(lambda u, v, w: 7800.0 * dot(u, v)).assemble(basis)
    place = {tuple(np.round(point, 9)): node for node, point in enumerate(nodes)}
    scalar = np.array([place[tuple(np.round(point, 9))] for point in basis.doflocs.T])
    axis = np.zeros(basis.N, int)  # which component each of their unknowns belongs to
    for component in range(3):
        axis[basis.get_dofs(elements=np.arange(len(elements))).all([f"u^{component + 1}"])] = component
    order = 3 * scalar + axis
    assert len(np.unique(order)) == basis.N
    for ours, other in zip(assemble(nodes, elements, **STEEL), theirs, strict=True):
        assert abs(ours[order][:, order] - other).max() < 1e-12 * abs(other).max()


def solved_with_manufactured_load(n):
    """Errors (L2, H1) for u = a sin(pi x) sin(pi y) sin(pi z) on the unit cube held all round, E = 1, nu = 0.3."""
    nodes, elements = box_mesh((1.0, 1.0, 1.0), (n, n, n))
    lam, mu = lame(1.0, 0.3)
    a, pi = np.array([1.0, -0.5, 0.7]), np.pi

    def exact(p):
        s, c = np.sin(pi * p), np.cos(pi * p)
        phi = s.prod(-1)
        slope = pi * np.stack([c[..., i] * s[..., (i + 1) % 3] * s[..., (i + 2) % 3] for i in range(3)], -1)
        hessian = np.empty((*phi.shape, 3, 3))
        for i in range(3):
            for j in range(3):
                third = s[..., 3 - i - j] if i != j else None
                hessian[..., i, j] = -(pi**2) * phi if i == j else pi**2 * c[..., i] * c[..., j] * third
        load = -((lam + mu) * hessian @ a - 3 * mu * pi**2 * phi[..., None] * a)
        return phi[..., None] * a, a[:, None] * slope[..., None, :], load

    K, _ = assemble(nodes, elements, elastic_modulus=1.0, poisson_ratio=0.3, density=1.0)
    points, weights = conical_rule(4)
    values, gradients = shape_values(points), shape_gradients(points)
    jacobian = np.einsum("ead,qar->eqdr", nodes[elements], gradients, optimize=True)
    dV = np.linalg.det(jacobian) * weights
    place = np.einsum("qa,ead->eqd", values, nodes[elements], optimize=True)
    u, slope, load = exact(place)
    right = np.zeros(len(nodes) * 3)
    np.add.at(right, unknowns(elements.ravel()), np.einsum("eq,qa,eqd->ead", dV, values, load, optimize=True).ravel())
    inside = unknowns(np.flatnonzero(((nodes > 1e-9) & (nodes < 1 - 1e-9)).all(axis=1)))
    found = np.zeros(len(nodes) * 3)
    found[inside] = factorize(K[inside][:, inside]).solve(right[inside])
    local = found.reshape(-1, 3)[elements]
    miss = np.einsum("qa,ead->eqd", values, local, optimize=True) - u
    space = np.einsum("qar,eqrd->eqad", gradients, np.linalg.inv(jacobian), optimize=True)
    miss_slope = np.einsum("eqad,eai->eqid", space, local, optimize=True) - slope
    return np.sqrt((dV * (miss**2).sum(-1)).sum()), np.sqrt((dV * (miss_slope**2).sum((-1, -2))).sum())


def test_errors_fall_with_third_and_second_order():
    coarse, fine = solved_with_manufactured_load(5), solved_with_manufactured_load(10)
    rate_l2, rate_h1 = np.log2(np.array(coarse) / np.array(fine))
    assert rate_l2 == pytest.approx(3.0, abs=0.15)
    assert rate_h1 == pytest.approx(2.0, abs=0.15)


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


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"poisson_ratio": 0.5}, "Poisson ratio is 0.5"),
        ({"elastic_modulus": -1.0}, "elastic modulus"),
        ({"density": 0.0}, "density"),
    ],
)
def test_material_outside_its_range_is_refused(change, message):
    nodes, elements = box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    with pytest.raises(ElementError, match=message):
        assemble(nodes, elements, **{**STEEL, **change})


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


@pytest.mark.parametrize("solver", SOLVERS)
class TestLinearSolver:
    def test_many_right_sides(self, block, solver):
        K, _, free = block
        matrix = K[free][:, free]
        X = np.random.default_rng(0).standard_normal((len(free), 5))
        B = matrix @ X
        kept = B.copy()
        factor = factorize(matrix, solver=solver)
        assert np.allclose(factor.solve(B), X, rtol=0, atol=1e-9)
        assert factor.solve(B[:, 0]).shape == (len(free),)
        assert np.array_equal(B, kept)
        assert {"multifrontal": "multifrontal", "superlu": "SuperLU", "cholmod": "CHOLMOD"}[solver] in factor.name

    def test_a_free_body_is_refused(self, block, solver):
        with pytest.raises(SingularMatrixError, match="not positive definite"):
            factorize(block[0], solver=solver)

    def test_an_indefinite_matrix_is_refused(self, block, solver):
        K, M, free = block
        shifted = K - 1e9 * M  # beyond some eigenvalues of the clamped block
        with pytest.raises(SingularMatrixError, match=r"negative|CHOLMOD stopped"):
            factorize(shifted[free][:, free], solver=solver)

    def test_a_loose_part_is_refused(self, block, solver):
        K, _, free = block
        with pytest.raises(SingularMatrixError):
            factorize(sp.block_diag([K[free][:, free], K]), solver=solver)


def test_not_square_and_not_finite_matrices_are_refused():
    with pytest.raises(ValueError, match="square"):
        factorize(sp.csr_matrix((2, 3)))
    with pytest.raises(ValueError, match="not finite"):
        factorize(sp.csr_matrix(np.array([[1.0, 0.0], [0.0, np.nan]])))


def test_nested_dissection_is_a_permutation_that_keeps_nodes_together(block):
    order = nested_dissection(block[0], 3)
    assert np.array_equal(np.sort(order), np.arange(block[0].shape[0]))
    assert np.array_equal(order.reshape(-1, 3) // 3, np.repeat(order[::3, None] // 3, 3, axis=1))
