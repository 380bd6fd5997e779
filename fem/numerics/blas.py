"""BLAS and LAPACK on blocks of arrays in place, without the interpreter lock.

SciPy's own wrappers keep the lock while they run and copy what is not contiguous. Here the routines of
`scipy.linalg.cython_blas` and `cython_lapack` are called by their addresses. Matrices are float64 with contiguous
columns (Fortran order); blocks of such arrays are taken as they lie.

Reference: Anderson et al. (1999), LAPACK Users' Guide, 3rd ed., SIAM.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

_Number = ctypes.POINTER(ctypes.c_int)
_Factor = ctypes.POINTER(ctypes.c_double)
_KINDS: dict[str, Any] = {"c": ctypes.c_char_p, "i": _Number, "f": _Factor, "a": ctypes.c_void_p}
_ARGUMENTS = {  # c: option, i: integer, f: factor, a: array
    "dgemm": "cciiifaiaifai",
    "dsyrk": "cciifaifai",
    "dtrsm": "cccciifaiai",
    "dpotrf": "ciaii",
    "dtrtri": "cciaii",
}


def add_product(A: np.ndarray, B: np.ndarray, C: np.ndarray, factor: float) -> None:
    """C += factor A B.

    Parameters
    ----------
    A, B, C : float64 (m, k), (k, n) and (m, n), columns contiguous; C is changed in place
    factor : of the product
    """
    if C.size and B.size:
        sizes = (*C.shape, A.shape[1])
        _call("dgemm", b"N", b"N", *sizes, factor, A, _lead(A), B, _lead(B), 1.0, C, _lead(C))


def add_square(B: np.ndarray, C: np.ndarray, factor: float) -> None:
    """Lower triangle of C += factor B B^T, with B (r, k), C (r, r)."""
    if B.size:
        _call("dsyrk", b"L", b"N", *B.shape, factor, B, _lead(B), 1.0, C, _lead(C))


def solve_left(L: np.ndarray, B: np.ndarray) -> None:
    """B := L^-1 B, L (k, k) lower triangular."""
    if B.size:
        _call("dtrsm", b"L", b"L", b"N", b"N", *B.shape, 1.0, L, _lead(L), B, _lead(B))


def solve_right(L: np.ndarray, B: np.ndarray, *, transposed: bool = False) -> None:
    """B := B L^-1, or B L^-T, L (k, k) lower triangular."""
    if B.size:
        _call("dtrsm", b"R", b"L", b"T" if transposed else b"N", b"N", *B.shape, 1.0, L, _lead(L), B, _lead(B))


def cholesky(A: np.ndarray) -> int:
    """Lower triangle of A := L with A = L L^T; 0, or the number (from 1) of the first pivot that is not positive."""
    return _call("dpotrf", b"L", len(A), A, _lead(A), 0)


def invert_lower(L: np.ndarray) -> None:
    """L := L^-1, lower triangular with a diagonal without zeros."""
    _call("dtrtri", b"L", b"N", len(L), L, _lead(L), 0)


def _lead(A: np.ndarray) -> int:
    """Distance of two columns in numbers; the routines cannot take any other form."""
    if A.dtype != np.float64 or (A.shape[0] > 1 and A.strides[0] != 8):
        raise ValueError(f"block of {A.dtype} with strides {A.strides}: columns of float64 must be contiguous")
    return max(A.strides[1] // 8 if A.shape[1] > 1 else 0, len(A), 1)


def _call(name: str, *given: Any) -> int:
    """Call a routine; its last integer argument as it leaves it."""
    arguments: list[Any] = []
    number = ctypes.c_int(0)
    for value in given:
        if isinstance(value, np.ndarray):
            arguments.append(value.ctypes.data)
        elif isinstance(value, bytes):
            arguments.append(value)
        elif isinstance(value, float):
            arguments.append(ctypes.byref(ctypes.c_double(value)))
        else:
            number = ctypes.c_int(value)
            arguments.append(ctypes.byref(number))
    _routine(name)(*arguments)
    return number.value


@cache
def _routine(name: str) -> Callable[..., None]:
    """The routine; calling it releases the interpreter lock."""
    from numba.extending import get_cython_function_address

    module = "cython_lapack" if name in ("dpotrf", "dtrtri") else "cython_blas"
    signature = ctypes.CFUNCTYPE(None, *(_KINDS[kind] for kind in _ARGUMENTS[name]))
    return signature(get_cython_function_address(f"scipy.linalg.{module}", name))
