"""Multifrontal factorisation and the count of negative eigenvalues, against dense linear algebra."""

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp
from solids import box_mesh, unknowns

from fem.elasticity import assemble
from fem.elimination import plan_elimination
from fem.multifrontal import Cholesky, NearlySingularError, NotDefiniteError, count_negative

STEEL = {"elastic_modulus": 2.0e11, "poisson_ratio": 0.3, "density": 7800.0}


@pytest.fixture(scope="module")
def plate():
    """Stiffness and mass (3,381 unknowns) of a clamped plate."""
    nodes, elements = box_mesh((1.0, 0.8, 0.05), (11, 9, 1), distortion=0.1)
    K, M = assemble(nodes, elements, **STEEL)
    free = unknowns(np.flatnonzero(nodes[:, 0] > 0))
    return K[free][:, free].tocsr(), M[free][:, free].tocsr()


def test_every_unknown_is_eliminated_once_and_rows_lie_behind(plate):
    plan = plan_elimination(plate[0], 3)
    assert np.array_equal(np.sort(plan.order), np.arange(plate[0].shape[0]))
    assert plan.starts[0] == 0
    assert plan.starts[-1] == plate[0].shape[0]
    for first_behind, rows, children in zip(plan.starts[1:], plan.rows, plan.children, strict=True):
        assert (np.diff(rows) > 0).all()
        assert not len(rows) or rows[0] >= first_behind
        for child in children:  # what a child leaves finds its place
            own = np.concatenate(
                [np.arange(plan.starts[list(plan.starts[1:]).index(first_behind)], first_behind), rows]
            )
            assert np.isin(plan.rows[child], own).all()


@pytest.mark.parametrize(("block", "columns"), [(3, 1), (3, 7), (1, 7)])
def test_solution_agrees_with_dense_algebra(plate, block, columns):
    K = plate[0]
    X = np.random.default_rng(0).standard_normal((K.shape[0], columns))
    found = Cholesky(plan_elimination(K, block), K).solve(K @ X)
    assert found == pytest.approx(X, abs=1e-8)


def test_pivots_multiply_to_the_determinant(plate):
    K = plate[0][:300][:, :300]
    pivots = Cholesky(plan_elimination(K, 3), K).pivots
    assert np.log(pivots).sum() == pytest.approx(np.linalg.slogdet(K.toarray())[1], rel=1e-12)


def test_a_matrix_of_loose_blocks_and_a_diagonal_one():
    A = sp.block_diag([sp.eye(3) * 4.0, np.array([[2.0, 1.0], [1.0, 3.0]]), [[5.0]]]).tocsr()
    assert Cholesky(plan_elimination(A), A).solve(A @ np.arange(6.0)) == pytest.approx(np.arange(6.0))
    D = sp.diags_array(np.arange(1.0, 8.0)).tocsr()
    assert Cholesky(plan_elimination(D), D).solve(np.ones(7)) == pytest.approx(1 / np.arange(1.0, 8.0))


def test_an_indefinite_matrix_is_refused(plate):
    K, M = plate
    with pytest.raises(NotDefiniteError, match="negative or zero"):
        Cholesky(plan_elimination(K, 3), K - 1e8 * M)


@pytest.mark.parametrize("held", [0, 5])
def test_negative_eigenvalues_are_counted_on_a_null_space(plate, held):
    """Against the dense eigenvalues on an orthonormal basis of the null space, at shifts from none to a hundred."""
    K, M = (matrix[:900][:, :900] for matrix in plate)
    rng = np.random.default_rng(1)
    rows = sp.random_array((held, K.shape[0]), density=0.01, rng=rng).tocsr()
    free = la.null_space(rows.toarray()) if held else np.eye(K.shape[0])
    value = la.eigh(free.T @ (K @ free), free.T @ (M @ free), eigvals_only=True)
    plan = plan_elimination(K, 3)
    for number in (0, 1, 17, 100):
        shift = 0.5 * (value[number - 1] + value[number]) if number else 0.5 * value[0]
        assert count_negative(plan, (K - shift * M).tocsr(), rows) == number


def test_a_singular_matrix_cannot_be_counted():
    A = sp.diags_array([1.0, 0.0, -2.0]).tocsr()
    with pytest.raises(NearlySingularError):
        count_negative(plan_elimination(A), A, sp.csr_matrix((0, 3)))


def test_a_coupling_may_stand_on_one_side_of_the_diagonal_only(plate):
    """Round-off cancels an entry on one side and not on the other: the plan must know it all the same."""
    stiffness = plate[0]
    load = np.ones(stiffness.shape[0])
    for part in (sp.triu, sp.tril):
        found = Cholesky(plan_elimination(part(stiffness), 1), stiffness).solve(load)
        assert stiffness @ found == pytest.approx(load, abs=1e-6)
