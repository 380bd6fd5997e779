"""Sparse matrix times a dense block, by two halves of the rows side by side; SciPy's product keeps the lock.

Importing this module imports numba.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fem.numerics.compiled import stored
from fem.numerics.side_by_side import side_by_side


def product(A: sp.csr_matrix, X: np.ndarray) -> np.ndarray:
    """A X of a sparse matrix (m, n) in rows and a dense block (n, k), by halves of the rows."""
    X = np.ascontiguousarray(X)
    out = np.empty((A.shape[0], X.shape[1]))
    half = A.shape[0] // 2
    side_by_side(
        lambda: _rows_product(A.indptr, A.indices, A.data, X, out, 0, half),
        lambda: _rows_product(A.indptr, A.indices, A.data, X, out, half, len(out)),
    )
    return out


@stored(__file__)
def _rows_product(
    indptr: np.ndarray, indices: np.ndarray, data: np.ndarray, X: np.ndarray, out: np.ndarray, begin: int, end: int
) -> None:
    """Rows `begin` to `end` of the product."""
    for i in range(begin, end):
        for c in range(X.shape[1]):
            out[i, c] = 0.0
        for p in range(indptr[i], indptr[i + 1]):
            value, j = data[p], indices[p]
            for c in range(X.shape[1]):
                out[i, c] += value * X[j, c]
