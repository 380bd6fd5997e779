"""Two pieces of work side by side.

Heavy steps are cut into two fixed halves, whatever the number of cores: their results do not depend on it, nor on which
half ends first. A half gains from a second core while it runs code that releases the interpreter lock: NumPy's matrix
products, compiled loops with `nogil`, and the calls of `fem.blas`; SciPy's wrappers of BLAS and LAPACK and its sparse
products keep the lock.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np
import scipy.sparse as sp
from numba import njit

One = TypeVar("One")
Other = TypeVar("Other")


def side_by_side(one: Callable[[], One], other: Callable[[], Other]) -> tuple[One, Other]:
    """The results of both; `other` runs in a thread of its own. What they raise is raised here, that of `one` first."""
    with ThreadPoolExecutor(max_workers=1) as pool:
        later = pool.submit(other)
        result = one()
    return result, later.result()


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


@njit(nogil=True, cache=True)
def _rows_product(
    indptr: np.ndarray, indices: np.ndarray, data: np.ndarray, X: np.ndarray, out: np.ndarray, begin: int, end: int
) -> None:
    """Rows `begin` to `end` of the product."""
    for i in range(begin, end):
        out[i, :] = 0.0
        for p in range(indptr[i], indptr[i + 1]):
            value, j = data[p], indices[p]
            for c in range(X.shape[1]):
                out[i, c] += value * X[j, c]
