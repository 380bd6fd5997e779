"""Largest eigenpairs of a self-adjoint operator by block Lanczos in the mass inner product.

    OP x = theta x,   OP = P M,   <x, y> = x^T M y,   theta = 1 / omega^2

P is a symmetric (pseudo-)inverse of the stiffness. A block of right-hand sides costs a fraction of single ones. Every
new block is orthogonalised twice against all earlier ones, so that no spurious copies of eigenvalues appear. The basis
grows until every eigenvalue above the limit has converged; the number of modes need not be known in advance.
`fem.casing.reduced.sturm_count` verifies it.

Reference: Grimes, Lewis & Simon (1994), SIAM J. Matrix Anal. Appl. 15(1), 228-272.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from fem.numerics import blas
from fem.numerics.side_by_side import side_by_side

_TOLERANCE = 1e-5  # residual of a Ritz pair over its theta: bound of the error of theta, which is about its square
_LARGEST_BASIS = 3000  # vectors
_CHUNK = 8  # blocks that share one array
_NOTHING = 1e-11  # share removed by reorthogonalisation below which its product with M is not computed
_RANK = 1e-12  # directions of a new block below this part of its largest (in mass norm squared) are dropped


class EigenError(RuntimeError):
    """The eigensolution did not converge."""


def m_orthonormal(X: np.ndarray, MX: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Combinations (k, r) that make X orthonormal in M, and their inverse (r, k); dependent directions are dropped.

    (Stathopoulos & Wu (2002), SIAM J. Sci. Comput. 23(6), 2165-2182, method SVQB.)
    """
    gram = X.T @ MX
    gram = 0.5 * (gram + gram.T)
    scale = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
    value, vector = la.eigh(gram / np.outer(scale, scale))
    keep = value > _RANK * max(value[-1], np.finfo(float).tiny)
    root = np.sqrt(value[keep])
    return vector[:, keep] / root / scale[:, None], (vector[:, keep] * root).T * scale


def block_lanczos(
    operator: Callable[[np.ndarray], np.ndarray],
    M: sp.csr_matrix,
    *,
    smallest: float | None = None,
    count: int | None = None,
    block: int = 16,
) -> tuple[np.ndarray, np.ndarray]:
    """Eigenpairs with theta >= `smallest`, or the `count` largest.

    Parameters
    ----------
    operator : X (n, k) -> P X (n, k), symmetric, positive semidefinite
    M : sparse (n, n), kg
    smallest, count : s2 and number of eigenpairs; give one of them
    block : number of vectors iterated together

    Returns
    -------
    theta : float (m,), descending; s2
    vectors : float (n, m), orthonormal in M

    Raises
    ------
    EigenError : no convergence within _LARGEST_BASIS vectors
    """
    from fem.numerics.sparse_product import product

    n = M.shape[0]
    X = operator(M @ np.random.default_rng(0).standard_normal((n, min(block, n))))
    for _ in range(2):
        X = X @ m_orthonormal(X, M @ X)[0]
    MX = M @ X
    basis = _Basis(n, _CHUNK * block)
    T = np.zeros((0, 0))  # the projected operator, block tridiagonal
    before, link = X[:, :0], np.zeros((X.shape[1], 0))
    step = 0
    while basis.used + (width := X.shape[1]) <= min(n, _LARGEST_BASIS):
        basis.append(X)
        step += 1
        W = np.ascontiguousarray(operator(MX))
        diagonal = MX.T @ W
        diagonal = 0.5 * (diagonal + diagonal.T)
        W -= before @ link.T
        W -= X @ diagonal
        MW = product(M, W)
        removed = basis.products(MW)
        basis.remove(W, removed)  # full reorthogonalisation
        T = _bordered(T, link, diagonal)
        combine, rest = m_orthonormal(W, MW)  # MW from before: the removed part is small, and a second pass follows
        exhausted = basis.used >= n or not rest.size or abs(rest).max() < 1e-13 * abs(np.diag(T)).max()
        if exhausted or step % 2 == 0:
            value, vector = la.eigh(T)
            value, vector = value[::-1], vector[:, ::-1]
            residual = np.linalg.norm(rest @ vector[basis.used - width :], axis=0)
            number = _wanted(value, residual, smallest, count, exhausted)
            if number is not None:
                return value[:number], basis.combined(vector[:, :number])
        before = X
        X = W @ combine
        MX = MW @ combine if abs(removed @ combine).max() <= _NOTHING else product(M, X)
        again, more = m_orthonormal(X, MX)  # the first pass squares the condition of the block
        X, MX, link = X @ again, MX @ again, more @ rest
    raise EigenError(
        f"block Lanczos found no {'band limit' if count is None else f'{count} modes'} within {basis.used} vectors "
        f"of a body with {n} unknowns; lower the band or the number of modes"
    )


def _wanted(
    value: np.ndarray, residual: np.ndarray, smallest: float | None, count: int | None, exhausted: bool
) -> int | None:
    """Number of leading Ritz pairs requested, None while they have not converged.

    The pair after the last requested one must have partly converged too, so that no other can appear in between. An
    exhausted basis (an invariant subspace) contains all modes.
    """
    number = int((value >= smallest).sum()) if smallest is not None else int(count or 0)
    if exhausted:
        return min(number, int((value > 0.0).sum()))
    if number + 1 > value.size or value[number] <= 0.0:
        return None
    converged = (residual[:number] <= _TOLERANCE * value[:number]).all()
    return number if converged and residual[number] <= 1e-3 * value[number] else None


def _bordered(T: np.ndarray, link: np.ndarray, diagonal: np.ndarray) -> np.ndarray:
    """T with one more diagonal block, coupled to the block before it by `link`."""
    k, w = len(T), len(diagonal)
    larger = np.zeros((k + w, k + w))
    larger[:k, :k], larger[k:, k:] = T, diagonal
    before = k - link.shape[1]
    larger[k:, before:k], larger[before:k, k:] = link, link.T
    return larger


class _Basis:
    """Vectors (n,) added in blocks, stored in chunks so that growth copies nothing."""

    def __init__(self, n: int, chunk: int) -> None:
        self._n, self._chunk = n, chunk
        self._parts: list[np.ndarray] = []  # (n, chunk), the last one filled to `_end`
        self._end = chunk
        self.used = 0

    def append(self, X: np.ndarray) -> None:
        """Add vectors (n, k), k no more than a chunk."""
        fits = min(X.shape[1], self._chunk - self._end)
        if fits:
            self._parts[-1][:, self._end : self._end + fits] = X[:, :fits]
        if fits < X.shape[1]:
            self._parts.append(np.empty((self._n, self._chunk)))
            self._parts[-1][:, : X.shape[1] - fits] = X[:, fits:]
        self._end = (self._end + X.shape[1] - 1) % self._chunk + 1
        self.used += X.shape[1]

    def _filled(self) -> list[np.ndarray]:
        return [*self._parts[:-1], self._parts[-1][:, : self._end]]

    def products(self, Y: np.ndarray) -> np.ndarray:
        """Q^T Y (used, k)."""
        halves = [np.array_split(part, 2, axis=1) for part in self._filled()]
        left, right = side_by_side(lambda: [p.T @ Y for p, _ in halves], lambda: [p.T @ Y for _, p in halves])
        return np.vstack([some for both in zip(left, right, strict=True) for some in both])

    def remove(self, W: np.ndarray, coefficients: np.ndarray) -> None:
        """W -= Q @ coefficients in place, W (n, k) by rows."""
        self._add(W, coefficients, -1.0)

    def combined(self, coefficients: np.ndarray) -> np.ndarray:
        """Q @ coefficients (n, k)."""
        out = np.zeros((self._n, coefficients.shape[1]))
        self._add(out, coefficients, 1.0)
        return out

    def _add(self, W: np.ndarray, coefficients: np.ndarray, factor: float) -> None:
        """W += factor Q @ coefficients in place, W by rows; in two parallel halves."""
        turned = np.asfortranarray(coefficients.T)

        def run(rows: slice) -> None:
            start = 0
            for part in self._filled():
                blas.add_product(turned[:, start : start + part.shape[1]], part[rows].T, W[rows].T, factor)
                start += part.shape[1]

        half = self._n // 2
        side_by_side(lambda: run(slice(half)), lambda: run(slice(half, None)))
