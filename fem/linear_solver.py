"""Direct solution of symmetric positive definite systems K x = b with many right sides.

CHOLMOD (supernodal Cholesky, nested dissection) when the optional package scikit-sparse is installed with an optimised
BLAS, else SuperLU of SciPy without pivoting on a METIS nested dissection ordering. On the reference BLAS, with which
Debian links CHOLMOD unless OpenBLAS is installed, it is the slower one: at 78,000 unknowns 46 against 20 ms for each
right side in blocks of 12, and no faster to factorise. Both refuse a matrix that is singular or indefinite. SuperLU
does not notice either by itself: the signs of its pivots and a residual are examined here.

References: Chen, Davis, Hager & Rajamanickam (2008), ACM TOMS 35(3), 22; Li (2005), ACM TOMS 31(3), 302-325;
Karypis & Kumar (1998), SIAM J. Sci. Comput. 20(1), 359-392.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.sparse as sp

from fem.ledger import count

Solver = Literal["auto", "cholmod", "superlu"]
_RESIDUAL_LIMIT = 1e-8
_PIVOT_LIMIT = 1e-13  # smallest pivot over largest diagonal entry: below it the matrix is singular to round-off


class SingularMatrixError(RuntimeError):
    """The matrix is singular or indefinite to working precision."""


@dataclass(frozen=True, eq=False)
class Factor:
    """A factorised matrix. `solve` takes (n,) or (n, k) and returns the same shape; it keeps its input unchanged."""

    name: str  # which code made it, for the provenance of results
    n: int
    solve: Callable[[np.ndarray], np.ndarray]


def cholmod_available() -> bool:
    """Whether the optional package scikit-sparse can be imported."""
    return importlib.util.find_spec("sksparse") is not None


def optimised_blas() -> bool:
    """Whether a BLAS beside those bundled with NumPy and SciPy is loaded that is not the plain reference one.

    Import scikit-sparse first. The reference BLAS is unknown to threadpoolctl, bundled ones lie in a folder *.libs.
    """
    from threadpoolctl import threadpool_info

    return any(pool["user_api"] == "blas" and ".libs" not in pool["filepath"] for pool in threadpool_info())


def _cholmod_is_faster() -> bool:
    if not cholmod_available():
        return False
    import sksparse.cholmod  # noqa: F401  (loads its BLAS)

    return optimised_blas()


def factorize(K: sp.spmatrix, *, solver: Solver = "auto", block: int = 3) -> Factor:
    """Factorise a sparse symmetric positive definite matrix.

    Parameters
    ----------
    K : sparse (n, n), symmetric
    solver : "auto" takes CHOLMOD when it is installed and has an optimised BLAS
    block : unknowns per node; the ordering works on nodes when n is a multiple of it

    Raises
    ------
    SingularMatrixError : K is singular or indefinite (a part without support, a negative modulus)
    ValueError : K is not square, or not finite
    ImportError : CHOLMOD asked for and scikit-sparse not installed
    """
    if solver == "cholmod" and not cholmod_available():
        raise ImportError("solver 'cholmod' needs scikit-sparse: pip install 'gearcase[cholmod]', or take 'superlu'")
    if K.shape[0] != K.shape[1] or K.shape[0] == 0:
        raise ValueError(f"matrix to factorise has shape {K.shape}; it must be square and not empty")
    K = sp.csc_matrix(K)
    if not np.isfinite(K.data).all():
        raise ValueError(f"matrix to factorise has {int((~np.isfinite(K.data)).sum())} entries that are not finite")
    use_cholmod = solver == "cholmod" or (solver == "auto" and _cholmod_is_faster())
    factor = _cholmod(K) if use_cholmod else _superlu(K, block)
    _check_residual(K, factor)
    count("factorisations")
    return factor


def _refuse(reason: str) -> SingularMatrixError:
    return SingularMatrixError(
        f"stiffness matrix is not positive definite: {reason}. "
        "Hold every rigid body motion of every connected part, and check the material constants"
    )


def _cholmod(K: sp.csc_matrix) -> Factor:
    from sksparse.cholmod import CholmodNotPositiveDefiniteError, cholesky

    try:
        cholesky_factor = cholesky(K, ordering_method="metis", mode="supernodal")
        diagonal = cholesky_factor.D()
    except CholmodNotPositiveDefiniteError as error:
        raise _refuse(f"CHOLMOD stopped with {error}") from error
    _check_pivots(diagonal, K)
    return Factor("CHOLMOD (scikit-sparse)", K.shape[0], lambda b: cholesky_factor(np.asarray(b, float)))


def _superlu(K: sp.csc_matrix, block: int) -> Factor:
    from scipy.sparse.linalg import splu

    order = nested_dissection(K, block)
    try:
        lu = splu(
            K[order][:, order].tocsc(),
            permc_spec="NATURAL",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:
        raise _refuse(f"SuperLU stopped with {error}") from error
    if not np.array_equal(lu.perm_r, np.arange(K.shape[0])):
        raise _refuse("SuperLU met a zero pivot")
    _check_pivots(lu.U.diagonal(), K)

    def solve(b: np.ndarray) -> np.ndarray:
        b = np.asarray(b, float)
        x = np.empty_like(b)
        x[order] = lu.solve(b[order])
        return x

    return Factor("SuperLU (SciPy) with METIS ordering", K.shape[0], solve)


def nested_dissection(K: sp.spmatrix, block: int = 1) -> np.ndarray:
    """Fill-reducing order (n,) of the unknowns by METIS; works on groups of `block` unknowns if n allows it."""
    import pymetis

    n = K.shape[0]
    if n % block:
        block = 1
    entries = sp.coo_matrix(K)
    row, col = entries.row // block, entries.col // block
    size = n // block
    adjacency = sp.csr_matrix((np.ones(row.size, np.int8), (row, col)), shape=(size, size))
    adjacency.setdiag(0)
    adjacency.eliminate_zeros()
    if adjacency.nnz == 0:
        return np.arange(n)
    if hasattr(pymetis, "CSRAdjacency"):
        graph = pymetis.CSRAdjacency(adj_starts=adjacency.indptr, adjacent=adjacency.indices)
        order = np.asarray(pymetis.nested_dissection(graph)[0])
    else:  # before pymetis 2025.2
        order = np.asarray(pymetis.nested_dissection(xadj=adjacency.indptr, adjncy=adjacency.indices)[0])
    return (order[:, None] * block + np.arange(block)).ravel()


def _check_pivots(pivots: np.ndarray, K: sp.csc_matrix) -> None:
    largest = abs(K.diagonal()).max()
    if (negative := int((pivots < 0.0).sum())) > 0:
        raise _refuse(f"{negative} of {pivots.size} pivots are negative")
    if pivots.min() <= _PIVOT_LIMIT * largest:
        raise _refuse(
            f"smallest pivot {pivots.min():.3g} against a largest diagonal of {largest:.3g} (limit {_PIVOT_LIMIT:g})"
        )


def _check_residual(K: sp.csc_matrix, factor: Factor) -> None:
    x = np.random.default_rng(1).standard_normal(factor.n)
    b = K @ x
    error = np.linalg.norm(K @ factor.solve(b) - b) / np.linalg.norm(b)
    if not error <= _RESIDUAL_LIMIT:
        raise _refuse(f"{factor.name} leaves a relative residual of {error:.3g} (limit {_RESIDUAL_LIMIT:g})")
