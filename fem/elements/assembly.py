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
    stiffness, mass : (pair, 3, 3) blocks, N/m, and one number (pair,), m3, for the pairs of functions of `pattern`
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
                mass[low] += masses[e, a, b]
                xx, yy, zz = products[0, e, a, b], products[1, e, a, b], products[2, e, a, b]
                xy, xz, yz = products[3, e, a, b], products[4, e, a, b], products[5, e, a, b]
                yx, zx, zy = products[3, e, b, a], products[4, e, b, a], products[5, e, b, a]
                shear = mu * (xx + yy + zz)
                stiffness[low, 0, 0] += (lam + mu) * xx + shear
                stiffness[low, 0, 1] += lam * xy + mu * yx
                stiffness[low, 0, 2] += lam * xz + mu * zx
                stiffness[low, 1, 0] += lam * yx + mu * xy
                stiffness[low, 1, 1] += (lam + mu) * yy + shear
                stiffness[low, 1, 2] += lam * yz + mu * zy
                stiffness[low, 2, 0] += lam * zx + mu * xz
                stiffness[low, 2, 1] += lam * zy + mu * yz
                stiffness[low, 2, 2] += (lam + mu) * zz + shear
