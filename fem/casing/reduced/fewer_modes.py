"""Fewer modes of a stored reduction: how many suffice, and the truncation to them, without finite elements.

A reduction with modes Phi, inertia corrections E (mass-orthonormal, K-orthogonal) and c = Psi^T M [Phi, E]
determines the whole correction P M Psi = [Phi, E] diag(1/omega^2) c^T. Truncation keeps the selected columns of Phi,
and replaces the other columns and E by the part of the correction in their span. The result equals a reduction computed
to the lower limit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from fem.casing.reduced.lanczos import m_orthonormal
from fem.casing.reduced.undamped_modes import on_springs


@dataclass(frozen=True, eq=False)
class ModeSet:
    """Reduced matrices of interface and modal coordinates; modal blocks are identity and diag(omega^2)."""

    stiffness: np.ndarray  # (b + m, b + m)
    mass: np.ndarray
    n_interface: int  # b
    n_fixed: int  # fixed-interface modes; the other m - n_fixed are inertia corrections
    basis: np.ndarray  # (larger, b + m): columns in the coordinates of the full set

    @property
    def fixed_frequencies(self) -> np.ndarray:
        """Hz, of the fixed-interface modes."""
        square = np.diag(self.stiffness)[self.n_interface : self.n_interface + self.n_fixed]
        return np.sqrt(square) / (2.0 * math.pi)


def kept(whole: ModeSet, n_fixed: int) -> ModeSet:
    """The same reduction with the `n_fixed` lowest fixed-interface modes."""
    if n_fixed == whole.n_fixed:
        return whole
    b, size = whole.n_interface, len(whole.mass)
    dropped = np.arange(b + n_fixed, size)
    square = np.diag(whole.stiffness)
    columns = np.eye(size)[:, : b + n_fixed]
    if size > b + whole.n_fixed:  # with inertia correction
        extra = whole.mass[dropped, :b] / square[dropped, None]
        for _ in range(2):
            extra = extra @ m_orthonormal(extra, extra)[0]
        value, vector = la.eigh(extra.T @ (square[dropped, None] * extra))
        corrections = np.zeros((size, len(value)))
        corrections[dropped] = extra @ vector
        columns = np.hstack([columns, corrections])
    stiffness = columns.T @ whole.stiffness @ columns
    stiffness[b:, b:] = np.diag(np.diag(stiffness)[b:])
    mass = columns.T @ whole.mass @ columns
    return ModeSet(
        stiffness=0.5 * (stiffness + stiffness.T),
        mass=0.5 * (mass + mass.T),
        n_interface=b,
        n_fixed=n_fixed,
        basis=whole.basis @ columns,
    )


def natural_frequencies(modes: ModeSet, springs: np.ndarray) -> np.ndarray:
    """Hz (b + m,), ascending, with springs (b,) at the interface coordinates."""
    square = la.eigh(on_springs(modes.stiffness, springs), modes.mass, eigvals_only=True)
    return np.sqrt(np.maximum(square, 0.0)) / (2.0 * math.pi)


def fewest_modes(whole: ModeSet, springs: np.ndarray, *, band: float, frequency_error: float) -> int:
    """Least number of fixed-interface modes with which every frequency up to `band` is within `frequency_error`.

    The number is found by bisection, as the error decreases with more modes (Rayleigh-Ritz).

    Parameters
    ----------
    whole : modes to choose from
    springs : (b,) N/m, at the interface coordinates
    band : Hz
    frequency_error : largest error, relative to the frequency with the whole set
    """
    exact = natural_frequencies(whole, springs)
    exact = exact[(exact <= band) & (exact > 1e-3 * band / len(exact))]
    skipped = int((natural_frequencies(whole, springs) < exact[0]).sum()) if len(exact) else 0

    def good(number: int) -> bool:
        found = natural_frequencies(kept(whole, number), springs)[skipped : skipped + len(exact)]
        return len(found) == len(exact) and float((found / exact - 1.0).max(initial=0.0)) <= frequency_error

    low, high = -1, whole.n_fixed  # low fails, high passes
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if good(middle) else (middle, high)
    return high
