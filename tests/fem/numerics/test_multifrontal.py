"""Multifrontal factorisation and the count of negative eigenvalues, against dense linear algebra."""

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp

import fem.numerics.multifrontal
from benchmarks.solids import box_mesh, unknowns
from fem.elements.solids import assemble
from fem.numerics import blas
from fem.numerics.elimination import plan_elimination
from fem.numerics.multifrontal import Cholesky, NearlySingularError, NotDefiniteError, count_negative
from fem.numerics.side_by_side import side_by_side
from fem.numerics.sparse_product import product

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


@pytest.mark.parametrize("block", [1, 3])
def test_columns_with_the_same_rows_behind_are_one_front(plate, block):
    """No front leaves exactly the rows of the next one: both together would store no zero more."""
    plan = plan_elimination(plate[0], block)
    for number, children in enumerate(plan.children):
        tall = plan.starts[number + 1] - plan.starts[number] + len(plan.rows[number])
        assert all(len(plan.rows[child]) < tall for child in children if child == number - 1)


@pytest.mark.parametrize(("block", "columns"), [(3, 1), (3, 7), (1, 7)])
def test_solution_agrees_with_dense_algebra(plate, block, columns):
    K = plate[0]
    X = np.random.default_rng(0).standard_normal((K.shape[0], columns))
    found = Cholesky(plan_elimination(K, block), K).solve(K @ X)
    assert found == pytest.approx(X, abs=1e-8)


@pytest.mark.parametrize("block", [2, 3, 4])
def test_unknowns_that_make_no_whole_number_of_groups(plate, block):
    K = plate[0][:-1][:, :-1] if plate[0].shape[0] % block == 0 else plate[0]
    assert K.shape[0] % block
    plan = plan_elimination(K, block)
    assert np.array_equal(np.sort(plan.order), np.arange(K.shape[0]))
    x = np.random.default_rng(0).standard_normal(K.shape[0])
    assert Cholesky(plan, K).solve(K @ x) == pytest.approx(x, abs=1e-8)
    assert len(plan.starts) <= len(plan_elimination(K, 1).starts)


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
    places, values = rng.random((2, held, K.shape[0]))
    rows = sp.csr_array(np.where(places < 0.01, values, 0.0))
    free = la.null_space(rows.toarray()) if held else np.eye(K.shape[0])
    value = la.eigh(free.T @ (K @ free), free.T @ (M @ free), eigvals_only=True)
    plan = plan_elimination(K, 3)
    for number in (0, 1, 17, 100):
        shift = 0.5 * (value[number - 1] + value[number]) if number else 0.5 * value[0]
        assert count_negative(plan, K, M, shift, rows) == number


def test_a_singular_matrix_cannot_be_counted():
    A = sp.diags_array([1.0, 0.0, -2.0]).tocsr()
    with pytest.raises(NearlySingularError):
        count_negative(plan_elimination(A), A, sp.csr_matrix(A.shape), 0.0, sp.csr_matrix((0, 3)))


def test_a_coupling_may_stand_on_one_side_of_the_diagonal_only(plate):
    """Round-off cancels an entry on one side and not on the other: the plan must know it all the same."""
    stiffness = plate[0]
    load = np.ones(stiffness.shape[0])
    for part in (sp.triu, sp.tril):
        found = Cholesky(plan_elimination(part(stiffness), 1), stiffness).solve(load)
        assert stiffness @ found == pytest.approx(load, abs=1e-6)


def test_the_halves_of_the_tree_do_not_touch_each_other(plate):
    plan = plan_elimination(plate[0], 3)
    first, second = plan.split
    assert 0 < first < second < len(plan.rows)
    for number, rows in enumerate(plan.rows[:second]):
        half = (number >= first) * plan.starts[first], plan.starts[(first, second)[number >= first]]
        assert ((rows < half[1]) | (rows >= plan.starts[second])).all()
        assert (rows >= half[0]).all()
    width = np.diff(plan.starts)
    work = np.array([float(w * (w + len(r))) for w, r in zip(width, plan.rows, strict=True)])
    longest = work[second:].sum() + max(work[:first].sum(), work[first:second].sum())
    assert longest < 0.75 * work.sum()


def test_numbers_do_not_depend_on_threads(plate, monkeypatch):
    """Bit for bit: repeated, and with the halves one after the other, in either order."""
    K = plate[0]
    X = np.random.default_rng(2).standard_normal((K.shape[0], 5))
    plan = plan_elimination(K, 3)
    factors = [Cholesky(plan, K), Cholesky(plan, K)]
    solutions = [factor.solve(X) for factor in factors]

    def reverse(one, other):
        later = other()
        return one(), later

    monkeypatch.setattr(fem.numerics.multifrontal, "side_by_side", reverse)
    factors.append(Cholesky(plan, K))
    solutions.append(factors[-1].solve(X))
    for factor, solution in zip(factors[1:], solutions[1:], strict=True):
        assert np.array_equal(factor.pivots, factors[0].pivots)
        assert np.array_equal(solution, solutions[0])


def test_a_failure_in_either_thread_is_raised():
    def fail():
        raise ValueError("no")

    for work in ((fail, int), (int, fail)):
        with pytest.raises(ValueError, match="no"):
            side_by_side(*work)


def test_sparse_product_by_halves(plate):
    X = np.random.default_rng(3).standard_normal((plate[0].shape[0], 7))
    for A, block in ((plate[0], X), (plate[0][:, :-3], X[:-3])):
        assert product(A, block) == pytest.approx(A @ block, rel=1e-12, abs=1e-9 * abs(A @ block).max())


def test_blocks_of_arrays_are_worked_on_in_place():
    """Every routine on blocks of larger arrays against plain algebra; what lies around a block stays."""
    rng = np.random.default_rng(4)
    whole = np.asfortranarray(rng.standard_normal((12, 6)))
    B, kept = whole[4:9], whole.copy()
    A = np.asfortranarray(rng.standard_normal((6, 6)))
    C = np.asfortranarray(A @ A.T + 6.0 * np.eye(6))
    square = C.copy()
    assert blas.cholesky(C) == 0
    L = np.tril(C)
    assert np.allclose(L @ L.T, square)
    blas.solve_right(C, B, transposed=True)
    assert np.allclose(B @ L.T, kept[4:9])
    blas.solve_right(C, B)
    assert np.allclose(B @ L @ L.T, kept[4:9])
    gram = np.zeros((5, 5), order="F")
    blas.add_square(B, gram, -2.0)
    assert np.tril(gram) == pytest.approx(np.tril(-2.0 * B @ B.T))
    right = A.copy()
    blas.solve_left(C, A)
    assert np.allclose(L @ A, right)
    wanted = whole[:4, :3] + 1.5 * B[:4] @ A[:, :3]
    blas.add_product(B[:4], A[:, :3], whole[:4, :3], 1.5)
    assert np.allclose(whole[:4, :3], wanted)
    blas.invert_lower(C)
    assert np.tril(C) @ L == pytest.approx(np.eye(6))
    assert np.array_equal(whole[:4, 3:], kept[:4, 3:])
    assert np.array_equal(whole[9:], kept[9:])
    assert blas.cholesky(np.asfortranarray(np.diag([1.0, -1.0, 1.0]))) == 2
    with pytest.raises(ValueError, match="must be contiguous"):
        blas.add_square(np.ones((3, 3)), gram[:3, :3], 1.0)
