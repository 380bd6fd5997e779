"""Largest eigenpairs of a self-adjoint operator by block Lanczos in the mass inner product.

    OP x = theta x,   OP = P M,   <x, y> = x^T M y,   theta = 1 / omega^2

P is a symmetric (pseudo-)inverse of the stiffness. Blocks of right sides cost a fraction of single ones; every new
block is orthogonalised against all earlier ones (twice), so no false copies of eigenvalues appear, and the basis
grows until every eigenvalue above the limit has converged: the number of modes need not be known beforehand.

Reference: Grimes, Lewis & Simon (1994), SIAM J. Matrix Anal. Appl. 15(1), 228-272.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

_TOLERANCE = 1e-7  # residual of a Ritz pair over its theta; the eigenvalue is then good to about its square
_RANK = 1e-12  # directions of a new block below this part of its largest (in mass norm squared) are dropped


class EigenError(RuntimeError):
    """The eigensolution did not converge."""


def m_orthonormal(X: np.ndarray, MX: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Combinations (k, r) that make X orthonormal in M, and their inverse (r, k); rank-deficient directions dropped.

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
    block: int = 8,
    largest_basis: int = 3000,
) -> tuple[np.ndarray, np.ndarray]:
    """Eigenpairs with theta >= `smallest`, or the `count` largest.

    Parameters
    ----------
    operator : X (n, k) -> P X (n, k), symmetric, positive semidefinite
    M : sparse (n, n), kg
    smallest, count : give one of them

    Returns
    -------
    theta : float (m,), descending; s2
    vectors : float (n, m), orthonormal in M

    Raises
    ------
    EigenError : no convergence within `largest_basis` vectors
    """
    if (smallest is None) == (count is None):
        raise ValueError("give either `smallest` or `count`")
    n = M.shape[0]
    X = operator(M @ np.random.default_rng(0).standard_normal((n, min(block, n))))
    for _ in range(2):
        X = X @ m_orthonormal(X, M @ X)[0]
    MX = M @ X
    basis = np.empty((n, min(n, 24 * block)), order="F")
    T = np.zeros((basis.shape[1], basis.shape[1]))  # the projected operator, block tridiagonal
    before, M_before, link = X[:, :0], MX[:, :0], np.zeros((X.shape[1], 0))
    used, step = 0, 0
    while used + (width := X.shape[1]) <= min(n, largest_basis):
        if used + 2 * width > basis.shape[1]:
            basis, T = _grown(basis, T, used, min(n + width, 3 * basis.shape[1] // 2 + width))
        here = slice(used, used + width)
        basis[:, here] = X
        used, step = used + width, step + 1
        Q = basis[:, :used]
        W = operator(MX)
        MW = M @ W
        W, MW = W - before @ link.T, MW - M_before @ link.T
        diagonal = X.T @ MW
        W, MW = W - X @ diagonal, MW - MX @ diagonal
        W -= Q @ (Q.T @ MW)  # full reorthogonalisation
        MW = M @ W
        T[here, here] = 0.5 * (diagonal + diagonal.T)
        combine, rest = m_orthonormal(W, MW)
        exhausted = used >= n or not rest.size or abs(rest).max() < 1e-13 * abs(np.diag(T[:used, :used])).max()
        if exhausted or step % 3 == 0:
            value, vector = la.eigh(T[:used, :used])
            value, vector = value[::-1], vector[:, ::-1]
            residual = np.linalg.norm(rest @ vector[used - width :], axis=0)
            number = _wanted(value, residual, smallest, count, exhausted)
            if number is not None:
                return value[:number], Q @ vector[:, :number]
        before, M_before = X, MX
        X = W @ combine
        again, more = m_orthonormal(X, M @ X)  # the first pass squares the condition of the block
        X, link = X @ again, more @ rest
        MX = M @ X
        T[used : used + X.shape[1], here], T[here, used : used + X.shape[1]] = link, link.T
    raise EigenError(
        f"block Lanczos found no {'band limit' if count is None else f'{count} modes'} within {used} vectors "
        f"of a body with {n} unknowns; lower the band or the number of modes"
    )


def _wanted(
    value: np.ndarray, residual: np.ndarray, smallest: float | None, count: int | None, exhausted: bool
) -> int | None:
    """How many leading Ritz pairs answer the question, None while they have not converged.

    The pair after the last wanted one must be on its way, too: then none can still appear in between. An exhausted
    basis (an invariant subspace) holds all modes that exist.
    """
    number = int((value >= smallest).sum()) if smallest is not None else int(count or 0)
    if exhausted:
        return min(number, int((value > 0.0).sum()))
    if number + 1 > value.size or value[number] <= 0.0:
        return None
    converged = (residual[:number] <= _TOLERANCE * value[:number]).all()
    return number if converged and residual[number] <= 1e-3 * value[number] else None


def _grown(basis: np.ndarray, T: np.ndarray, used: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    larger, larger_T = np.empty((basis.shape[0], size), order="F"), np.zeros((size, size))
    larger[:, :used], larger_T[: len(T), : len(T)] = basis[:, :used], T
    return larger, larger_T
