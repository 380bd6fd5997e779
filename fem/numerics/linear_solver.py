"""Direct solution of symmetric positive definite systems K x = b with many right sides.

The default is the multifrontal Cholesky factorisation of `fem.numerics.multifrontal` with an ordering by METIS; it
needs only the BLAS inside SciPy. If pymetis cannot be imported, SciPy's SuperLU without pivoting is used with a
warning; it is also an independent second solver. CHOLMOD is used on request if the optional package scikit-sparse is
installed. With an optimised BLAS it is about as fast as the default, with the reference BLAS several times slower. All
three raise an error if the matrix is singular or indefinite; as SuperLU does not detect this, the signs of its pivots
and a residual are checked here.

References: Duff & Reid (1983), ACM TOMS 9(3), 302-325; Li (2005), ACM TOMS 31(3), 302-325; Chen, Davis, Hager &
Rajamanickam (2008), ACM TOMS 35(3), 22.
"""

from __future__ import annotations

import importlib.util
import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
import scipy.sparse as sp

from fem.numerics.memory import give_back
from fem.storage.ledger import count

if TYPE_CHECKING:
    from fem.numerics.elimination import Elimination

Solver = Literal["auto", "multifrontal", "cholmod", "superlu"]
_LOG = logging.getLogger(__name__)
_RESIDUAL_LIMIT = 1e-8
_PIVOT_LIMIT = 1e-13  # smallest pivot over largest diagonal entry: below it the matrix is singular to round-off


class SingularMatrixError(RuntimeError):
    """The matrix is singular or indefinite to working precision; `unknown` has a negative or zero pivot, if known."""

    unknown: int | None = None


@dataclass(frozen=True, eq=False)
class Factor:
    """A factorised matrix. `solve` takes (n,) or (n, k) and returns the same shape; it does not change its input."""

    name: str  # solver and ordering, for the provenance of results
    n: int
    solve: Callable[[np.ndarray], np.ndarray]
    plan: Elimination | None = None  # of the multifrontal factor, for other matrices of the same pattern


def cholmod_available() -> bool:
    """Whether the optional package scikit-sparse can be imported."""
    return importlib.util.find_spec("sksparse") is not None


def metis_available() -> bool:
    """Whether pymetis can be imported."""
    return importlib.util.find_spec("pymetis") is not None


def factorize(K: sp.spmatrix, *, solver: Solver = "auto", block: int = 3) -> Factor:
    """Factorise a sparse symmetric positive definite matrix.

    Parameters
    ----------
    K : sparse (n, n), symmetric
    solver : "auto" is "multifrontal", or "superlu" with a warning in the log where pymetis is missing
    block : unknowns per node; the ordering works on nodes

    Raises
    ------
    SingularMatrixError : K is singular or indefinite (a part without support, a negative modulus)
    ValueError : K is not square, or not finite
    ImportError : `solver` is "cholmod" and scikit-sparse is not installed
    """
    if solver == "cholmod" and not cholmod_available():
        raise ImportError("solver 'cholmod' needs scikit-sparse: pip install 'gearcase[cholmod]', or take 'superlu'")
    if K.shape[0] != K.shape[1] or K.shape[0] == 0:
        raise ValueError(f"matrix to factorise has shape {K.shape}; it must be square and not empty")
    K = sp.csc_matrix(K.T if K.format == "csr" else K)  # symmetric: its rows are its columns
    if not np.isfinite(K.data).all():
        raise ValueError(f"matrix to factorise has {int((~np.isfinite(K.data)).sum())} entries that are not finite")
    if solver == "auto":
        solver = "multifrontal" if metis_available() else "superlu"
        if solver == "superlu":
            _LOG.warning("pymetis cannot be imported: SciPy's SuperLU solves instead, several times slower")
    factor = {"multifrontal": _multifrontal, "cholmod": _cholmod, "superlu": _superlu}[solver](K, block)
    _check_residual(K, factor)
    count("factorisations")
    return factor


def _refuse(reason: str) -> SingularMatrixError:
    return SingularMatrixError(
        f"stiffness matrix is not positive definite: {reason}. "
        "Hold every rigid body motion of every connected part, and check the material constants"
    )


def _multifrontal(K: sp.csc_matrix, block: int) -> Factor:
    from fem.numerics.elimination import plan_elimination
    from fem.numerics.multifrontal import Cholesky, NotDefiniteError

    plan = plan_elimination(K, block)
    give_back()
    try:
        cholesky_factor = Cholesky(plan, K)
    except NotDefiniteError as error:
        refused = _refuse(str(error))
        refused.unknown = error.unknown
        raise refused from error
    give_back()
    _check_pivots(cholesky_factor.pivots, K)
    return Factor("multifrontal Cholesky with METIS ordering", K.shape[0], cholesky_factor.solve, plan)


def _cholmod(K: sp.csc_matrix, block: int) -> Factor:
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

    with_metis = metis_available()
    order = nested_dissection(K, block) if with_metis else np.arange(K.shape[0])
    try:
        lu = splu(
            K[order][:, order].tocsc(),
            permc_spec="NATURAL" if with_metis else "MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:
        raise _refuse(f"SuperLU stopped with {error}") from error
    if not np.array_equal(lu.perm_r, lu.perm_c):
        raise _refuse("SuperLU met a zero pivot")
    _check_pivots(lu.U.diagonal(), K)

    def solve(b: np.ndarray) -> np.ndarray:
        b = np.asarray(b, float)
        x = np.empty_like(b)
        x[order] = lu.solve(b[order])
        return x

    ordering = "METIS" if with_metis else "minimum degree"
    return Factor(f"SuperLU (SciPy) with {ordering} ordering", K.shape[0], solve)


def nested_dissection(K: sp.spmatrix, block: int = 1) -> np.ndarray:
    """Fill-reducing order (n,) of the unknowns by METIS, which works on groups of `block` unknowns."""
    from fem.numerics.elimination import dissect, firsts, group_graph, members

    return members(dissect(group_graph(K, block)), firsts(K.shape[0], block))


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
