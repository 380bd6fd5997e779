"""Multifrontal Cholesky factorisation K = L L^T on dense fronts, and the number of negative eigenvalues of K.

Each supernode assembles its entries and the update matrices of its children in a front [[A, .], [B, C]] (lower
triangle),

    A = L1 L1^T,   update matrix C - B A^-1 B^T,   stored panel P = [L1^-1; B A^-1],

so that the solution for many right sides is one matrix product per supernode down the tree and one up. All arithmetic
is done by the BLAS and LAPACK of NumPy and SciPy. The two halves of the tree (`Elimination.split`) are processed in
parallel, then the supernodes above both. Where A is not definite, blocks of its columns are eliminated by their
eigenvalues, whose signs give the Sturm-sequence count.

References: Duff & Reid (1983), ACM TOMS 9(3), 302-325; Liu (1992), SIAM Review 34(1), 82-109.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Callable, Sequence

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from fem.numerics import blas
from fem.numerics.compiled import stored
from fem.numerics.elimination import Elimination, rows_of
from fem.numerics.side_by_side import side_by_side

_STRIP = 64  # columns of an indefinite front eliminated at once
_SMALL = 1e-11  # eigenvalue of a strip over its largest diagonal entry: below it round-off may change the sign

# panels one after the other, each by columns; their ends; first unknowns, and one beyond the last; rows; their ends
Store = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]


class NotDefiniteError(ValueError):
    """The matrix is not positive definite: the pivot of an unknown is negative or zero."""

    def __init__(self, unknown: int) -> None:
        super().__init__(f"the pivot of unknown {unknown} is negative or zero")
        self.unknown = unknown


class NearlySingularError(ValueError):
    """A pivot is so small that round-off may change its sign."""


class Cholesky:
    """Factor of a positive definite matrix; `pivots` are the squares of the diagonal of L."""

    name = "multifrontal Cholesky with METIS ordering"  # for the provenance of results

    def __init__(self, plan: Elimination, K: sp.spmatrix) -> None:
        self.plan = plan  # also for other matrices of the same pattern
        width, height = np.diff(plan.starts), np.array([len(rows) for rows in plan.rows])
        ends = np.cumsum(width * (width + height))
        panels = np.zeros(ends[-1])
        row_ends = np.cumsum(height)
        self._store: Store = (panels, ends, plan.starts, np.concatenate(plan.rows), row_ends)
        pivots = np.empty(K.shape[0])

        def panel(number: int) -> np.ndarray:
            return panels[ends[number] - width[number] * (width[number] + height[number]) : ends[number]]

        def eliminate(number: int, A: np.ndarray, B: np.ndarray, C: np.ndarray) -> None:
            first = plan.starts[number]
            if failed := blas.cholesky(A):
                raise NotDefiniteError(int(plan.order[first + failed - 1]))
            pivots[first : first + len(A)] = np.diag(A) ** 2
            blas.solve_right(A, B, transposed=True)
            blas.add_square(B, C, -1.0)
            blas.solve_right(A, B)
            blas.invert_lower(A)

        _eliminate_all(plan, [(1.0, K)], panel, eliminate)
        self.pivots = pivots

    def solve(self, b: np.ndarray) -> np.ndarray:
        """K^-1 b for b (n,) or (n, k), which is not changed."""
        x = np.ascontiguousarray(np.asarray(b, float).reshape(len(self.plan.order), -1)[self.plan.order])
        starts = self._store[2]
        (first, second), last = self.plan.split, len(starts) - 1
        top = int(starts[second])
        passed = np.zeros((2, len(x) - top, x.shape[1]))
        side_by_side(
            lambda: _down(x, passed[0], top, self._store, 0, first),
            lambda: _down(x, passed[1], top, self._store, first, second),
        )
        x[top:] -= passed[0] + passed[1]
        _down(x, passed[0], len(x), self._store, second, last)
        _up(x, self._store, second, last)
        side_by_side(lambda: _up(x, self._store, 0, first), lambda: _up(x, self._store, first, second))
        out = np.empty_like(x)
        out[self.plan.order] = x
        return out.reshape(np.shape(b))


@stored(__file__)
def _down(x: np.ndarray, passed: np.ndarray, top: int, store: Store, begin: int, end: int) -> None:
    """L^-1 x on the supernodes `begin` to `end`; the contribution to unknowns from `top` on is added to `passed`."""
    panels, ends, starts, rows, row_ends = store
    for s in range(begin, end):
        first, k = starts[s], starts[s + 1] - starts[s]
        own = rows[row_ends[s - 1] if s else 0 : row_ends[s]]
        m = k + len(own)
        y = np.dot(x[first : first + k].T.copy(), panels[ends[s] - k * m : ends[s]].reshape(k, m))
        for j in range(k):
            for c in range(len(y)):
                x[first + j, c] = y[c, j]
        for i, row in enumerate(own):
            for c in range(len(y)):
                if row < top:
                    x[row, c] -= y[c, k + i]
                else:
                    passed[row - top, c] += y[c, k + i]


@stored(__file__)
def _up(x: np.ndarray, store: Store, begin: int, end: int) -> None:
    """L^-T x on the supernodes `end` to `begin`."""
    panels, ends, starts, rows, row_ends = store
    for s in range(end - 1, begin - 1, -1):
        first, k = starts[s], starts[s + 1] - starts[s]
        own = rows[row_ends[s - 1] if s else 0 : row_ends[s]]
        m = k + len(own)
        y = np.empty((m, x.shape[1]))
        for c in range(x.shape[1]):  # element by element: assigned slices take seconds to compile
            for j in range(k):
                y[j, c] = x[first + j, c]
            for i in range(m - k):
                y[k + i, c] = -x[own[i], c]
        found = np.dot(panels[ends[s] - k * m : ends[s]].reshape(k, m), y)
        for c in range(x.shape[1]):
            for j in range(k):
                x[first + j, c] = found[j, c]


def count_negative(plan: Elimination, K: sp.spmatrix, M: sp.spmatrix, shift: float, rows: sp.spmatrix) -> int:
    """Number of negative eigenvalues of A = K - shift M, symmetric, on the null space of `rows`.

    With R of full rank and A regular, In(A on R x = 0) = In(A) + In(-R A^-1 R^T) - (b, b, 0), which follows from the
    inertia of the matrix bordered by R. The factor is not stored.

    Parameters
    ----------
    plan : of a matrix whose pattern contains that of A
    K, M : sparse (n, n)
    shift : 1/s2
    rows : sparse R (b, n)

    Raises
    ------
    NearlySingularError : A, or a leading submatrix of it, has an eigenvalue of nearly zero

    References
    ----------
    Haynsworth (1968), Linear Algebra Appl. 1(1), 73-81.
    """
    first, second = plan.split
    top, b = int(plan.starts[second]), rows.shape[0]
    loads = sp.csr_matrix(rows)[:, plan.order].T.toarray()
    passed = np.zeros((2, len(loads) - top, b))  # contributions of the halves to the loads of the top
    schur, negative = np.zeros((3, b, b)), [0, 0, 0]  # of both halves and of the top
    scale = abs(K.diagonal() - shift * M.diagonal())[plan.order]

    def leave(number: int, change: np.ndarray) -> None:
        behind = plan.rows[number]
        if number >= second:
            loads[behind] -= change
            return
        below = int(np.searchsorted(behind, top))
        loads[behind[:below]] -= change[:below]
        passed[int(number >= first)][behind[below:] - top] += change[below:]

    def eliminate(number: int, A: np.ndarray, B: np.ndarray, C: np.ndarray) -> None:
        begin, end = plan.starts[number], plan.starts[number + 1]
        part = int(number >= first) + int(number >= second)
        own = np.array(loads[begin:end], order="F")
        if part == 2:
            own -= passed[0, begin - top : end - top] + passed[1, begin - top : end - top]
        lower = np.array(A, order="F")
        if not blas.cholesky(lower):
            blas.solve_left(lower, own)
            blas.solve_right(lower, B, transposed=True)
            blas.add_square(B, C, -1.0)
            leave(number, B @ own)
            schur[part] += own.T @ own
            return
        A += np.tril(A, -1).T
        k = len(A)
        front, values = np.asfortranarray(np.vstack([A, B])), np.empty(k)
        for start in range(0, k, _STRIP):
            strip, behind = slice(start, min(start + _STRIP, k)), slice(min(start + _STRIP, k), None)
            value, vector = np.linalg.eigh(front[strip, strip])
            if abs(value).min() <= _SMALL * (size := scale[begin + strip.start : begin + strip.stop].max()):
                raise NearlySingularError(f"pivot {value[abs(value).argmin()]:.3g} against {size:.3g}")
            values[strip] = value
            front[behind, strip] = front[behind, strip] @ vector
            turned, load = front[behind, strip], vector.T @ own[strip]
            scaled = np.asfortranarray((turned[: k - behind.start] / value).T)
            blas.add_product(turned, scaled, front[behind, behind], -1.0)
            change = turned @ (load.T / value).T
            own[behind] -= change[: k - behind.start]
            leave(number, change[k - behind.start :])
            schur[part] += (load.T / value) @ load
        negative[part] += int((values < 0.0).sum())
        turned = front[k:] / np.sqrt(abs(values))
        blas.add_square(np.asfortranarray(turned[:, values > 0.0]), C, -1.0)
        blas.add_square(np.asfortranarray(turned[:, values < 0.0]), C, 1.0)

    sizes = [int(k) * (int(k) + len(behind)) for k, behind in zip(np.diff(plan.starts), plan.rows, strict=True)]
    panels = np.empty((2, max(sizes)))  # one for each half; the top uses that of the first

    def scratch(number: int) -> np.ndarray:
        panel = panels[int(first <= number < second), : sizes[number]]
        panel[:] = 0.0
        return panel

    _eliminate_all(plan, [(1.0, K), (-shift, M)], scratch, eliminate)
    whole = schur.sum(axis=0)
    return sum(negative) - int((la.eigvalsh(0.5 * (whole + whole.T)) < 0.0).sum()) if b else sum(negative)


def _eliminate_all(
    plan: Elimination,
    terms: Sequence[tuple[float, sp.spmatrix]],
    panel: Callable[[int], np.ndarray],
    eliminate: Callable[[int, np.ndarray, np.ndarray, np.ndarray], None],
) -> None:
    """Assemble the fronts of a sum of factors times symmetric matrices; `eliminate` puts the update matrix in C.

    `panel` returns the memory of A (k, k) and B (r, k) for a supernode, filled with zeros. Of C, only the lower
    triangle is used, to which update matrices of children have been added.
    """
    columns = [(factor, rows_of(matrix)) for factor, matrix in terms]
    turned = np.empty(len(plan.order), np.int32)
    turned[plan.order] = np.arange(len(plan.order))
    left: dict[int, tuple[np.ndarray, np.ndarray]] = {}

    def run(begin: int, stop: int) -> None:
        place, buffers = np.zeros(len(plan.order), np.int64), _Buffers()
        for number in range(begin, stop):
            first, end, rows = plan.starts[number], plan.starts[number + 1], plan.rows[number]
            k, r = int(end - first), len(rows)
            front, remainder = panel(number).reshape(k, k + r).T, buffers.zeros(r * r)
            A, B, C = front[:k], front[k:], remainder.reshape(r, r).T
            place[rows] = np.arange(r)
            for factor, own in columns:
                _own_entries(A, B, own.indptr, own.indices, own.data, factor, plan.order, turned, first, place)
            for child in plan.children[number]:
                change, used = left.pop(child)
                _add(A, B, C, change, plan.rows[child], first, place)
                buffers.give_back(used)
            eliminate(number, A, B, C)
            left[number] = C, remainder

    half, both = plan.split
    side_by_side(lambda: run(0, half), lambda: run(half, both))
    run(both, len(plan.rows))


class _Buffers:
    """Memory that is reused: pages that are new to a process take longer than the arithmetic on them."""

    def __init__(self) -> None:
        self._free: list[np.ndarray] = []  # by size

    def zeros(self, size: int) -> np.ndarray:
        """Zeros (size,) in the smallest buffer that is large enough."""
        place = bisect_left(self._free, size, key=len)
        buffer = self._free.pop(place) if place < len(self._free) else np.empty(size)
        out = buffer[:size]
        out[:] = 0.0
        return out

    def give_back(self, out: np.ndarray) -> None:
        """Take back an array of `zeros` that is not needed any more."""
        insort(self._free, out if out.base is None else out.base, key=len)


@stored(__file__)
def _own_entries(
    A: np.ndarray,
    B: np.ndarray,
    indptr: np.ndarray,
    indices: np.ndarray,
    data: np.ndarray,
    factor: float,
    order: np.ndarray,
    turned: np.ndarray,
    first: int,
    place: np.ndarray,
) -> None:
    """Add factor times the lower triangle of the matrix in the columns of the front."""
    k = A.shape[1]
    for j in range(k):
        column = order[first + j]
        for p in range(indptr[column], indptr[column + 1]):
            row = turned[indices[p]]
            i = row - first
            if i >= k:
                B[place[row], j] += factor * data[p]
            elif i >= j:
                A[i, j] += factor * data[p]


@stored(__file__)
def _add(
    A: np.ndarray, B: np.ndarray, C: np.ndarray, left: np.ndarray, rows: np.ndarray, first: int, place: np.ndarray
) -> None:
    """Add the lower triangle of the update matrix of a child, with its `rows`."""
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
