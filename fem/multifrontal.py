"""Multifrontal Cholesky factorisation K = L L^T on dense fronts, and the number of negative eigenvalues of K.

Every supernode gathers its entries and what its children leave into a front [[A, .], [B, C]] (lower triangle),

    A = L1 L1^T,   remainder C - B A^-1 B^T,   stored panel P = [L1^-1; B A^-1],

so that a solution with many right sides is one matrix product per supernode down the tree and one up. All arithmetic
is done by the BLAS and LAPACK that come with NumPy and SciPy. Where A is not definite, blocks of its columns are
eliminated by their eigenvalues, whose signs are counted (Sylvester's law of inertia).

References: Duff & Reid (1983), ACM TOMS 9(3), 302-325; Liu (1992), SIAM Review 34(1), 82-109.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from numba import njit
from scipy.linalg.blas import dgemm, dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf, dtrtri

from fem.elimination import Elimination

_STRIP = 64  # columns of an indefinite front eliminated at once
_SMALL = 1e-11  # eigenvalue of a strip over its largest diagonal entry: below it the sign is not to be trusted


class NotDefiniteError(ValueError):
    """The matrix is not positive definite."""


class NearlySingularError(ValueError):
    """A pivot is too small for its sign to be trusted."""


class Cholesky:
    """Factor of a positive definite matrix; `pivots` are the squares of the diagonal of L."""

    def __init__(self, plan: Elimination, K: sp.spmatrix) -> None:
        self._plan = plan
        self._panels: list[np.ndarray] = []
        pivots = np.empty(K.shape[0])

        def eliminate(number: int, A: np.ndarray, B: np.ndarray, C: np.ndarray) -> np.ndarray:
            lower, failed = dpotrf(A, lower=1, overwrite_a=1, clean=1)
            first = plan.starts[number]
            if failed:
                unknown = int(plan.order[first + failed - 1])
                raise NotDefiniteError(f"the pivot of unknown {unknown} is negative or zero")
            pivots[first : first + len(A)] = np.diag(lower) ** 2
            if len(B):
                B = dtrsm(1.0, lower, B, side=1, lower=1, trans_a=1, overwrite_b=1)
                C = dsyrk(-1.0, B, beta=1.0, c=C, lower=1, overwrite_c=1)
                B = dtrsm(1.0, lower, B, side=1, lower=1, overwrite_b=1)
            inverse, _ = dtrtri(lower, lower=1, overwrite_c=1)
            self._panels.append(np.asfortranarray(np.vstack([inverse, B])))
            return C

        _eliminate_all(plan, K, eliminate)
        self.pivots = pivots

    def solve(self, b: np.ndarray) -> np.ndarray:
        """K^-1 b of b (n,) or (n, k)."""
        plan = self._plan
        x = np.ascontiguousarray(np.asarray(b, float).reshape(len(plan.order), -1)[plan.order])
        spans = list(zip(plan.starts[:-1], plan.starts[1:], plan.rows, self._panels, strict=True))
        for first, end, rows, panel in spans:
            y = dgemm(1.0, panel, x[first:end])  # with contiguous columns: faster for thin blocks than `@`
            x[first:end] = y[: end - first]
            x[rows] -= y[end - first :]
        for first, end, rows, panel in reversed(spans):
            y = np.empty((len(panel), x.shape[1]), order="F")
            y[: end - first] = x[first:end]
            np.negative(x[rows], out=y[end - first :])
            x[first:end] = dgemm(1.0, panel, y, trans_a=1)
        out = np.empty_like(x)
        out[plan.order] = x
        return out.reshape(np.shape(b))


def count_negative(plan: Elimination, A: sp.spmatrix, rows: sp.spmatrix) -> int:
    """Number of negative eigenvalues of a symmetric matrix on the null space of `rows`.

    With R of full rank and A regular, In(A on R x = 0) = In(A) + In(-R A^-1 R^T) - (b, b, 0): the matrix bordered by R
    has both inertias. Nothing of the factor is kept.

    Parameters
    ----------
    plan : of a matrix whose pattern contains that of A
    A : sparse (n, n); rows : sparse R (b, n)

    Raises
    ------
    NearlySingularError : A has an eigenvalue (nearly) zero, or a leading part of it has

    References
    ----------
    Haynsworth (1968), Linear Algebra Appl. 1(1), 73-81.
    """
    loads = np.ascontiguousarray(sp.csr_matrix(rows)[:, plan.order].T.toarray())
    schur = np.zeros((rows.shape[0], rows.shape[0]))
    negative, scale = 0, abs(A.diagonal())[plan.order]

    def eliminate(number: int, A: np.ndarray, B: np.ndarray, C: np.ndarray) -> np.ndarray:
        nonlocal negative, schur
        first, end = plan.starts[number], plan.starts[number + 1]
        lower, failed = dpotrf(A, lower=1)
        if not failed:
            own = dtrsm(1.0, lower, loads[first:end], lower=1)
            if len(B):
                B = dtrsm(1.0, lower, B, side=1, lower=1, trans_a=1, overwrite_b=1)
                C = dsyrk(-1.0, B, beta=1.0, c=C, lower=1, overwrite_c=1)
                loads[plan.rows[number]] -= B @ own
            schur += own.T @ own
            return C
        C += np.tril(C, -1).T
        front = np.vstack([np.tril(A) + np.tril(A, -1).T, B])
        own, k = loads[first:end], len(A)
        for start in range(0, k, _STRIP):
            strip = slice(start, min(start + _STRIP, k))
            value, vector = la.eigh(front[strip, strip])
            if abs(value).min() <= _SMALL * (size := scale[first + strip.start : first + strip.stop].max()):
                raise NearlySingularError(f"pivot {value[abs(value).argmin()]:.3g} against {size:.3g}")
            negative += int((value < 0.0).sum())
            turned, load = front[strip.stop :, strip] @ vector, vector.T @ own[strip]
            scaled = turned / value
            front[strip.stop :, strip.stop :] -= scaled @ turned[: k - strip.stop].T
            C -= scaled[k - strip.stop :] @ turned[k - strip.stop :].T
            passed = scaled @ load
            own[strip.stop :] -= passed[: k - strip.stop]
            loads[plan.rows[number]] -= passed[k - strip.stop :]
            schur += (load.T / value) @ load
        return C

    _eliminate_all(plan, A, eliminate)
    return negative - int((la.eigvalsh(0.5 * (schur + schur.T)) < 0.0).sum()) if len(schur) else negative


def _eliminate_all(
    plan: Elimination,
    K: sp.spmatrix,
    eliminate: Callable[[int, np.ndarray, np.ndarray, np.ndarray], np.ndarray],
) -> None:
    """Form the fronts one after the other and hand each to `eliminate`, which returns what is left of its C."""
    columns = sp.csc_matrix(K)[plan.order][:, plan.order]
    columns = sp.csc_matrix(columns)
    place = np.zeros(K.shape[0], np.int64)
    left: dict[int, np.ndarray] = {}
    for number, (first, end, rows) in enumerate(zip(plan.starts[:-1], plan.starts[1:], plan.rows, strict=True)):
        k, r = int(end - first), len(rows)
        A, B, C = (np.zeros(shape, order="F") for shape in ((k, k), (r, k), (r, r)))
        place[rows] = np.arange(r)
        _own_entries(A, B, columns.indptr, columns.indices, columns.data, first, place)
        for child in plan.children[number]:
            _add(A, B, C, left.pop(child), plan.rows[child], first, place)
        left[number] = eliminate(number, A, B, C)


@njit(cache=True)
def _own_entries(
    A: np.ndarray,
    B: np.ndarray,
    indptr: np.ndarray,
    indices: np.ndarray,
    data: np.ndarray,
    first: int,
    place: np.ndarray,
) -> None:
    """Lower triangle of the matrix in the columns of the front."""
    k = A.shape[1]
    for j in range(k):
        for p in range(indptr[first + j], indptr[first + j + 1]):
            i = indices[p] - first
            if i >= k:
                B[place[indices[p]], j] = data[p]
            elif i >= j:
                A[i, j] = data[p]


@njit(cache=True)
def _add(
    A: np.ndarray, B: np.ndarray, C: np.ndarray, left: np.ndarray, rows: np.ndarray, first: int, place: np.ndarray
) -> None:
    """Add the lower triangle that a child leaves on its `rows`."""
    k, m = A.shape[1], len(rows)
    split = 0  # rows before it are eliminated here
    while split < m and rows[split] < first + k:
        split += 1
    target = np.empty(m, np.int64)
    for i in range(m):
        target[i] = rows[i] - first if i < split else place[rows[i]]
    for j in range(split):
        column = target[j]
        for i in range(j, split):
            A[target[i], column] += left[i, j]
        for i in range(split, m):
            B[target[i], column] += left[i, j]
    for j in range(split, m):
        column = target[j]
        for i in range(j, m):
            C[target[i], column] += left[i, j]
