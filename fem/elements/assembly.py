"""Assembly of element matrices of an isotropic solid into sparse matrices with a given pattern.

Importing this module imports numba.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fem.numerics.compiled import stored


def pattern(own: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Row ends and ascending columns of the functions that share an element.

    Parameters
    ----------
    own : int32 (element, k), functions of every element, -1: held
    count : of all functions
    """
    element, place = np.nonzero(own >= 0)
    used = sp.csr_matrix((np.ones(len(element), np.int32), (element, own[element, place])), shape=(len(own), count))
    found = sp.csr_matrix(used.T @ used)
    found.sort_indices()
    return found.indptr.astype(np.int32), found.indices.astype(np.int32)


def three_each(indptr: np.ndarray, indices: np.ndarray) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Matrices of zeros for three unknowns a function: coupled along all axes, and along the same axis only.

    Parameters
    ----------
    indptr, indices : those of `pattern`
    """
    count, axes = len(indptr) - 1, np.arange(3, dtype=np.int32)
    thrice = sp.csr_matrix((indices, indices, indptr), shape=(count, count))[np.repeat(np.arange(count), 3)]
    first = 3 * thrice.indices
    K = (np.zeros(3 * len(first)), (first[:, None] + axes).ravel(), 3 * thrice.indptr)
    M = (np.zeros(len(first)), first + np.repeat(np.tile(axes, count), np.diff(thrice.indptr)), thrice.indptr)
    return sp.csr_matrix(K, shape=(3 * count, 3 * count)), sp.csr_matrix(M, shape=(3 * count, 3 * count))


@stored(__file__)
def add_elements(
    own: np.ndarray,
    known: int,
    products: np.ndarray,
    masses: np.ndarray,
    lam: float,
    mu: float,
    indptr: np.ndarray,
    indices: np.ndarray,
    stiffness: np.ndarray,
    mass: np.ndarray,
) -> None:
    """Add the stiffness and the mass of unit density of some elements.

    Parameters
    ----------
    own : int32 (e, k), functions of every element, -1: held
    known : number of first functions whose mutual pairs are omitted
    products, masses : (6, e, k, k) by `fem.elements.solid_elements.AXES`, m, and (e, k, k), m3
    lam, mu : Lame constants, Pa
    indptr, indices : those of `pattern`
    stiffness, mass : (9 pair,) N/m and (3 pair,) m3, entries of matrices with three unknowns a function, by their rows
    """
    for e in range(own.shape[0]):
        for a in range(own.shape[1]):
            row = own[e, a]
            if row < 0:
                continue
            for b in range(known if a < known else 0, own.shape[1]):
                column = own[e, b]
                if column < 0:
                    continue
                low, high = indptr[row], indptr[row + 1]
                while high - low > 1:
                    middle = (low + high) // 2
                    if indices[middle] <= column:
                        low = middle
                    else:
                        high = middle
                before, wide = low - indptr[row], indptr[row + 1] - indptr[row]
                for axis in range(3):
                    mass[3 * indptr[row] + axis * wide + before] += masses[e, a, b]
                xx, yy, zz = products[0, e, a, b], products[1, e, a, b], products[2, e, a, b]
                xy, xz, yz = products[3, e, a, b], products[4, e, a, b], products[5, e, a, b]
                yx, zx, zy = products[3, e, b, a], products[4, e, b, a], products[5, e, b, a]
                shear = mu * (xx + yy + zz)
                own_rows = stiffness[9 * indptr[row] : 9 * indptr[row + 1]].reshape(3, wide, 3)[:, before]
                own_rows[0, 0] += (lam + mu) * xx + shear
                own_rows[0, 1] += lam * xy + mu * yx
                own_rows[0, 2] += lam * xz + mu * zx
                own_rows[1, 0] += lam * yx + mu * xy
                own_rows[1, 1] += (lam + mu) * yy + shear
                own_rows[1, 2] += lam * yz + mu * zy
                own_rows[2, 0] += lam * zx + mu * xz
                own_rows[2, 1] += lam * zy + mu * yz
                own_rows[2, 2] += (lam + mu) * zz + shear
