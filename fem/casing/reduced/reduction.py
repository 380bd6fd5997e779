"""Static condensation (Guyan) and Craig-Bampton reduction on linear interfaces u_b = B u.

`fem.casing.reduced.sturm_count` verifies that no fixed-interface mode is missed.

B holds rows of any kind: unit rows (plain degrees of freedom) or the mean motion of patches, which are not degrees of
freedom and cannot be partitioned. With A = K + B^T D B (D = 0 if K is already definite), S = B A^-1 B^T:

    Psi = A^-1 B^T S^-1                      constraint modes, B Psi = 1
    P = A^-1 - Psi B A^-1                    inverse of K on B u = 0
    P M phi = phi / omega^2                  fixed-interface modes, B phi = 0
    E = P M Psi                              inertia correction of the constraint modes, first order
    u = Psi u_b + Phi eta,   K_r = diag(S^-1 - D, omega^2),   M_r = [[Psi^T M Psi, Psi^T M Phi], [., 1]]

E is orthonormalised against Phi and appended to its columns.

References: Guyan (1965), AIAA J. 3(2), 380; Craig & Bampton (1968), AIAA J. 6(7), 1313-1319; Rixen (2004),
J. Comput. Appl. Math. 168, 383-391; O'Callahan (1989), Proc. 7th IMAC, 17-21 (inertia correction).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from fem.casing.reduced.lanczos import block_lanczos, m_orthonormal
from fem.numerics.linear_solver import factorize

if TYPE_CHECKING:
    from fem.numerics.multifrontal import Cholesky

_DENSE = 400  # largest number of unknowns for a dense eigensolution on the null space of B
_SPANNED = 1e-12  # share of the mass of a vector outside the span of the modes, below which it is round-off


class ReductionError(ValueError):
    """The interface rows are not independent, the number of modes does not exist, or mounts do not fit the feet."""


@dataclass(frozen=True, eq=False)
class Reduction:
    """A basis u = T @ [u_b, eta] with its reduced matrices."""

    constraint: np.ndarray  # Psi (n, b)
    modes: np.ndarray  # Phi and E (n, m), orthonormal in M
    frequencies: np.ndarray  # Hz (m,), fixed interface; those of E last
    n_fixed: int  # columns of Phi; the rest are E
    stiffness: np.ndarray  # (b + m, b + m)
    mass: np.ndarray
    loaded: np.ndarray  # displacements (n, l) under the loads of the interface
    solver: str  # name of the factor

    @property
    def basis(self) -> np.ndarray:
        """T (n, b + m), a copy."""
        return np.hstack([self.constraint, self.modes])

    def expanded(self, coordinates: np.ndarray) -> np.ndarray:
        """T coordinates (n, k), for coordinates (b + m, k), without a copy of T."""
        b = self.constraint.shape[1]
        return self.constraint @ coordinates[:b] + self.modes @ coordinates[b:]

    def projected(self, loads: np.ndarray) -> np.ndarray:
        """T^T loads, for loads (n, k)."""
        return np.vstack([self.constraint.T @ loads, self.modes.T @ loads])


@dataclass(frozen=True, eq=False)
class Interface:
    """A factorised body with its interface rows and constraint modes."""

    factor: Cholesky
    rows: sp.csr_matrix  # B (b, n)
    constraint: np.ndarray  # Psi (n, b)
    stiffness: np.ndarray  # S^-1 - D (b, b)
    loaded: np.ndarray  # A^-1 loads (n, l)

    def inverse(self, X: np.ndarray) -> np.ndarray:
        """P X: displacements under the loads X (n, k) with the interface held."""
        Y = self.factor.solve(X)
        Y -= self.constraint @ (self.rows @ Y)
        return Y


def held_interface(
    K: sp.spmatrix,
    rows: sp.spmatrix,
    *,
    penalty: np.ndarray | None = None,
    loads: np.ndarray | sp.csr_matrix | None = None,
) -> Interface:
    """Factorise A = K + B^T D B and compute the constraint modes.

    Parameters
    ----------
    K : sparse (n, n), N/m; positive definite together with the penalty
    rows : sparse B (b, n)
    penalty : diagonal of D (b,), N/m; needed only when K alone is singular
    loads : (n, l), whose displacements are needed after the factor is freed; none by default

    Raises
    ------
    ReductionError : interface rows are linearly dependent
    SingularMatrixError : A is not positive definite
    """
    rows = sp.csr_matrix(rows)
    A = K if penalty is None else K + rows.T @ sp.diags_array(penalty) @ rows
    factor = factorize(A)
    b = rows.shape[0]
    found = factor.solve(sp.hstack([rows.T, *([] if loads is None else [loads])]).toarray())
    flexible = found[:, :b]  # A^-1 B^T
    S = rows @ flexible
    S = 0.5 * (S + S.T)
    scale = np.sqrt(np.diag(S))
    if S.size and not (np.isfinite(scale).all() and np.linalg.cond(S / np.outer(scale, scale)) < 1e12):
        raise ReductionError(f"the {len(S)} interface rows are not independent; remove a row or separate the patches")
    inverse = la.inv(S) if S.size else S
    stiffness = 0.5 * (inverse + inverse.T) - (np.diag(penalty) if penalty is not None else 0.0)
    return Interface(factor, rows, flexible @ inverse, stiffness, found[:, b:].copy())


def reduce_body(
    interface: Interface,
    K: sp.spmatrix,
    M: sp.spmatrix,
    *,
    highest: float | None = None,
    count: int | None = None,
    enrich: bool = True,
) -> Reduction:
    """Reduce a body to its interface and fixed-interface modes.

    Parameters
    ----------
    interface : of the same body
    K, M : sparse (n, n), stiffness and mass in SI; K without the penalty of the interface
    highest : Hz, keep every mode up to it; or
    count : number of modes kept, 0 gives static condensation
    enrich : add the inertia correction (as many columns as there are interface coordinates, if independent)

    Raises
    ------
    ReductionError : more modes requested than exist
    EigenError : the eigensolution did not converge
    """
    from fem.numerics.sparse_product import product

    M = sp.csr_matrix(M)
    theta, modes = _fixed_modes(interface, K, M, highest, count)
    frequencies = 1.0 / (2.0 * math.pi * np.sqrt(theta))
    n_fixed = len(theta)
    Psi = interface.constraint
    M_Psi = product(M, Psi)
    extra = _beyond(modes, interface.inverse(M_Psi), M) if enrich and Psi.shape[1] else modes[:, :0]
    if extra.shape[1]:
        value, vector = la.eigh(_symmetric(extra.T @ product(sp.csr_matrix(K), extra)))
        modes = np.hstack([modes, extra @ vector])
        frequencies = np.concatenate([frequencies, np.sqrt(value) / (2.0 * math.pi)])
    between = M_Psi.T @ modes
    mass = np.block([[_symmetric(M_Psi.T @ Psi), between], [between.T, np.eye(modes.shape[1])]])
    stiffness = la.block_diag(interface.stiffness, np.diag((2.0 * math.pi * frequencies) ** 2))
    return Reduction(Psi, modes, frequencies, n_fixed, stiffness, mass, interface.loaded, interface.factor.name)


def _beyond(modes: np.ndarray, extra: np.ndarray, M: sp.csr_matrix) -> np.ndarray:
    """Part (n, r) of vectors (n, k) outside the span of modes (n, m), orthonormal in M; dependent ones are dropped.

    Normalised, the round-off of a vector within the span would become a spurious mode.
    """
    from fem.numerics.sparse_product import product

    M_extra = product(M, extra)
    whole = np.einsum("ij,ij->j", extra, M_extra)
    extra = extra - modes @ (modes.T @ M_extra)
    M_extra = product(M, extra)
    outside = np.einsum("ij,ij->j", extra, M_extra) > _SPANNED * whole
    if not outside.any():
        return extra[:, :0]
    extra, M_extra = extra[:, outside], M_extra[:, outside]
    combine = m_orthonormal(extra, M_extra)[0]
    extra, M_extra = extra @ combine, M_extra @ combine
    extra = extra - modes @ (modes.T @ M_extra)
    return extra @ m_orthonormal(extra, product(M, extra))[0]


def largest_entry(matrix: sp.csr_matrix) -> float:
    """Largest entry by magnitude, computed without a copy."""
    return float(max(matrix.data.max(initial=0.0), -matrix.data.min(initial=0.0)))


def _symmetric(matrix: np.ndarray) -> np.ndarray:
    return 0.5 * (matrix + matrix.T)


def _fixed_modes(
    interface: Interface, K: sp.spmatrix, M: sp.csr_matrix, highest: float | None, count: int | None
) -> tuple[np.ndarray, np.ndarray]:
    """Theta = 1/omega^2 (m,), descending, and modes (n, m) of P M."""
    n, held = M.shape[0], interface.rows.shape[0]
    smallest = None if highest is None else (2.0 * math.pi * highest) ** -2.0
    if count == 0:
        return np.zeros(0), np.zeros((n, 0))
    if count is not None and count > n - held:
        raise ReductionError(f"{count} modes requested; a body of {n} unknowns with {held} held has at most {n - held}")
    if n > _DENSE:
        return block_lanczos(interface.inverse, M, smallest=smallest, count=count)
    free = la.null_space(interface.rows.toarray()) if held else np.eye(n)
    theta, modes = la.eigh(free.T @ (M @ free), free.T @ (K @ free))
    theta, modes = theta[::-1], (free @ modes)[:, ::-1]
    exists = theta > 1e-14 * theta[0]  # massless unknowns have theta = 0
    number = int((exists & (theta >= smallest)).sum()) if smallest is not None else int(count or 0)
    if number > exists.sum():
        raise ReductionError(f"{number} modes requested; only {int(exists.sum())} have mass")
    theta, modes = theta[:number], modes[:, :number]
    return theta, modes / np.sqrt(theta)
