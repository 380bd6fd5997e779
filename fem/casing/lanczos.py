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

_TOLERANCE = 1e-8  # residual of a Ritz pair over its theta; the eigenvalue is then good to about its square
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
    block: int = 12,
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
    # M-orthonormal basis in one growing array; T is the projected operator
    X = operator(M @ np.random.default_rng(0).standard_normal((n, min(block, n))))
    X = X @ m_orthonormal(X, M @ X)[0]
    X = X @ m_orthonormal(X, M @ X)[0]
    basis = np.empty((n, min(n, 16 * block)), order="F")
    T = np.zeros((basis.shape[1], basis.shape[1]))
    used, step = 0, 0
    while X.shape[1]:
        width = X.shape[1]
        if used + width > min(n, largest_basis):
            break
        if used + width > basis.shape[1]:
            basis, T = _grown(basis, T, used, 2 * basis.shape[1])
        basis[:, used : used + width] = X
        used += width
        Q = basis[:, :used]
        W = operator(M @ X)
        projection = Q.T @ (M @ W)
        T[:used, used - width : used] = projection
        T[used - width : used, :used] = projection.T
        W -= Q @ projection
        W -= Q @ (Q.T @ (M @ W))
        combine, rest = m_orthonormal(W, M @ W)
        X = W @ combine
        step += 1
        scale = abs(projection[-width:]).max()
        if rest.size and abs(rest).max() < 1e-13 * max(scale, abs(T[:used, :used]).max()):
            X = X[:, :0]  # an invariant subspace: all modes that exist are in it
        if step % 2 and X.shape[1]:
            continue
        value, vector = la.eigh(0.5 * (T[:used, :used] + T[:used, :used].T))
        value, vector = value[::-1], vector[:, ::-1]
        residual = np.linalg.norm(rest @ vector[used - width :], axis=0) if X.shape[1] else np.zeros(used)
        wanted = _wanted(value, residual, smallest, count)
        if wanted is not None or not X.shape[1]:
            number = int((value > 0.0).sum()) if wanted is None else wanted
            if wanted is None:
                number = int((value >= smallest).sum()) if smallest is not None else min(count or 0, number)
            return value[:number], Q @ vector[:, :number]
        X = X - Q @ (Q.T @ (M @ X))
        X = X @ m_orthonormal(X, M @ X)[0]
    raise EigenError(
        f"block Lanczos found no {'band limit' if count is None else f'{count} modes'} within {used} vectors "
        f"of a body with {n} unknowns; lower the band or the number of modes"
    )


def _wanted(value: np.ndarray, residual: np.ndarray, smallest: float | None, count: int | None) -> int | None:
    """How many leading Ritz pairs answer the question, None while they have not converged.

    The pair after the last wanted one must have converged, too: then none can still appear in between.
    """
    number = int((value >= smallest).sum()) if smallest is not None else int(count or 0)
    if number + 1 > value.size or value[number] <= 0.0:
        return None
    good = residual[: number + 1] <= _TOLERANCE * value[: number + 1]
    good[-1] = residual[number] <= 1e-3 * value[number]
    return number if good.all() else None


def _grown(basis: np.ndarray, T: np.ndarray, used: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    larger, larger_T = np.empty((basis.shape[0], size), order="F"), np.zeros((size, size))
    larger[:, :used], larger_T[:used, :used] = basis[:, :used], T[:used, :used]
    return larger, larger_T
