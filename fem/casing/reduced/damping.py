"""Damping of a reduced body: a damping ratio for every mode, by one number or by a table over frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy.linalg as la

DampingRatio = float | Sequence[Sequence[float]]  # zeta, or rows (Hz, zeta) with rising frequencies


def damping_ratios(damping: DampingRatio, frequencies: np.ndarray) -> np.ndarray:
    """Zeta at frequencies (Hz); a table is interpolated linearly and constant beyond its ends.

    Raises
    ------
    ValueError : a ratio outside 0 <= zeta < 1, frequencies of the table that do not rise
    """
    table = np.atleast_2d(np.asarray([[0.0, damping]] if np.isscalar(damping) else damping, float))
    if table.ndim != 2 or table.shape[1] != 2 or not len(table) or not np.isfinite(table).all():
        raise ValueError("casing damping: give a ratio, or rows of [frequency in Hz, ratio]")
    if (wrong := table[(table[:, 1] < 0.0) | (table[:, 1] >= 1.0), 1]).size:
        raise ValueError(f"casing damping ratio is {wrong[0]:g}; give a value from 0 to below 1 (cast iron about 0.01)")
    if (table[0, 0] < 0.0) or (np.diff(table[:, 0]) <= 0.0).any():
        raise ValueError(f"casing damping: the frequencies {table[:, 0].tolist()} Hz do not rise from 0 or more")
    return np.interp(frequencies, table[:, 0], table[:, 1])


def modal_damping(mass: np.ndarray, stiffness: np.ndarray, damping: DampingRatio) -> np.ndarray:
    """C = M Phi diag(2 zeta_k omega_k) Phi^T M of the modes of (K, M).

    Parameters
    ----------
    mass, stiffness : float (n, n), positive definite
    damping : zeta of all modes, or rows (Hz, zeta)
    """
    if not len(mass):
        damping_ratios(damping, np.zeros(1))
        return np.zeros((0, 0))
    square, phi = la.eigh(stiffness, mass)
    omega = np.sqrt(np.maximum(square, 0.0))
    weighted = mass @ phi
    return (weighted * (2.0 * damping_ratios(damping, omega / (2.0 * math.pi)) * omega)) @ weighted.T
