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
    stiffness, mass : rows of 3 x 3 blocks in the order of `coupled`, and one number per pair
    """
    for e in range(own.shape[0]):
        for a in range(own.shape[1]):
            row = own[e, a]
            if row < 0:
                continue
            first, end = indptr[row], indptr[row + 1]
            for b in range(known if a < known else 0, own.shape[1]):
                column = own[e, b]
                if column < 0:
                    continue
                low, high = first, end
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
                at, step = 9 * first + 3 * (low - first), 3 * (end - first)
                stiffness[at] += (lam + mu) * xx + shear
                stiffness[at + 1] += lam * xy + mu * yx
                stiffness[at + 2] += lam * xz + mu * zx
                at += step
                stiffness[at] += lam * yx + mu * xy
                stiffness[at + 1] += (lam + mu) * yy + shear
                stiffness[at + 2] += lam * yz + mu * zy
                at += step
                stiffness[at] += lam * zx + mu * xz
                stiffness[at + 1] += lam * zy + mu * yz
                stiffness[at + 2] += (lam + mu) * zz + shear


@stored(__file__)
def coupled(indptr: np.ndarray, indices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns and row ends of a matrix of full 3 x 3 blocks."""
    columns, ends = np.empty(9 * len(indices), np.int32), np.zeros(3 * len(indptr) - 2, np.int32)
    at = 0
    for row in range(len(indptr) - 1):
        for i in range(3):
            for p in range(indptr[row], indptr[row + 1]):
                for j in range(3):
                    columns[at] = 3 * indices[p] + j
                    at += 1
            ends[3 * row + i + 1] = at
    return columns, ends


@stored(__file__)
def uncoupled(indptr: np.ndarray, indices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns and row ends of a matrix of diagonal 3 x 3 blocks."""
    columns, ends = np.empty(3 * len(indices), np.int32), np.zeros(3 * len(indptr) - 2, np.int32)
    at = 0
    for row in range(len(indptr) - 1):
        for i in range(3):
            for p in range(indptr[row], indptr[row + 1]):
                columns[at] = 3 * indices[p] + i
                at += 1
            ends[3 * row + i + 1] = at
    return columns, ends


def thrice(indptr: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The entries of `uncoupled`: values in row order, every row repeated three times."""
    length, out = np.diff(indptr), np.empty(3 * len(values))
    starts = np.repeat(2 * indptr[:-1], length)
    for i in range(3):
        out[np.arange(len(values)) + starts + i * np.repeat(length, length)] = values
    return out
