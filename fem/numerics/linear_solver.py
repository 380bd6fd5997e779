"""Direct solution of symmetric positive definite systems K x = b with many right sides.

The multifrontal Cholesky factorisation of `fem.numerics.multifrontal` with an ordering by METIS needs only the BLAS
inside SciPy. A singular or indefinite matrix is refused; the smallest pivot and a residual are checked too.

Reference: Duff & Reid (1983), ACM TOMS 9(3), 302-325.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from fem.numerics.memory import give_back
from fem.storage.ledger import count

if TYPE_CHECKING:
    from fem.numerics.multifrontal import Cholesky

_RESIDUAL_LIMIT = 1e-8
_PIVOT_LIMIT = 1e-13  # smallest pivot over largest diagonal entry: below it the matrix is singular to round-off


class SingularMatrixError(RuntimeError):
    """The matrix is singular or indefinite to working precision; `unknown` has a negative or zero pivot, if known."""

    def __init__(self, reason: str, unknown: int | None = None) -> None:
        super().__init__(
            f"stiffness matrix is not positive definite: {reason}. "
            "Hold every rigid body motion of every connected part, and check the material constants"
        )
        self.unknown = unknown


def factorize(K: sp.spmatrix, *, block: int = 3) -> Cholesky:
    """Factorise a sparse symmetric positive definite matrix.

    Parameters
    ----------
    K : sparse (n, n), symmetric
    block : unknowns per node; the ordering works on nodes

    Raises
    ------
    SingularMatrixError : K is singular or indefinite (a part without support, a negative modulus)
    ValueError : K is not square, or not finite
    """
    from fem.numerics.elimination import plan_elimination  # late: these import numba
    from fem.numerics.multifrontal import Cholesky, NotDefiniteError

    if K.shape[0] != K.shape[1] or K.shape[0] == 0:
        raise ValueError(f"matrix to factorise has shape {K.shape}; it must be square and not empty")
    K = sp.csc_matrix(K.T if K.format == "csr" else K)  # symmetric: its rows are its columns
    if not np.isfinite(K.data).all():
        raise ValueError(f"matrix to factorise has {int((~np.isfinite(K.data)).sum())} entries that are not finite")
    plan = plan_elimination(K, block)
    give_back()
    try:
        factor = Cholesky(plan, K)
    except NotDefiniteError as error:
        raise SingularMatrixError(str(error), error.unknown) from error
    give_back()
    smallest, largest = factor.pivots.min(), abs(K.diagonal()).max()
    if smallest <= _PIVOT_LIMIT * largest:
        raise SingularMatrixError(
            f"smallest pivot {smallest:.3g} against a largest diagonal of {largest:.3g} (limit {_PIVOT_LIMIT:g})"
        )
    b = K @ np.random.default_rng(1).standard_normal(K.shape[0])
    residual = np.linalg.norm(K @ factor.solve(b) - b) / np.linalg.norm(b)
    if not residual <= _RESIDUAL_LIMIT:
        raise SingularMatrixError(f"a relative residual of {residual:.3g} is left (limit {_RESIDUAL_LIMIT:g})")
    count("factorisations")
    return factor
