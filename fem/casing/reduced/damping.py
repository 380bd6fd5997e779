"""Damping of a reduced body: damping ratios of its modes, from one number, a table over frequency, or loss factors.

Parts with separate loss factors eta_p damp a mode by their shares s_p of its strain energy,

    zeta = sum_p s_p eta_p / 2 + (1 - sum_p s_p) zeta_0,    s_p = phi^T K_p phi / phi^T K phi

with the ratio zeta_0 of the remaining body. Modes are those of the undamped body: valid for small damping.

References: Ungar & Kerwin (1962), J. Acoust. Soc. Am. 34(7), 954-957; Johnson & Kienholz (1982), AIAA J. 20(9),
1284-1290 (modal strain energy method).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy.linalg as la

from fem.casing.parts.casing_choices import DampingRatio


def damping_ratios(damping: DampingRatio, frequencies: np.ndarray) -> np.ndarray:
    """Zeta at frequencies (Hz); a table is interpolated linearly and constant beyond its ends."""
    table = np.atleast_2d(np.asarray([[0.0, damping]] if np.isscalar(damping) else damping, float))
    return np.interp(frequencies, table[:, 0], table[:, 1])


def ratios_with_parts(ratios: np.ndarray, shares: np.ndarray, loss_factors: Sequence[float]) -> np.ndarray:
    """Zeta (mode,) of modes of a body whose parts have separate loss factors.

    Parameters
    ----------
    ratios : (mode,), zeta_0 of the remaining body at the frequencies of the modes
    shares : (part, mode) of the strain energy, see `energy_shares`
    loss_factors : (part,)
    """
    eta = np.asarray(loss_factors, float)
    return np.asarray(ratios + shares.T @ (0.5 * eta) - shares.sum(axis=0) * ratios)


def energy_shares(parts: Sequence[np.ndarray], vectors: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Share (part, mode) of each part of the stiffness in the strain energy of every vector (coordinate, mode)."""
    whole = np.einsum("ik,ij,jk->k", vectors, stiffness, vectors, optimize=True)
    found = [np.einsum("ik,ij,jk->k", vectors, part, vectors, optimize=True) for part in parts]
    return np.array(found).reshape(len(parts), vectors.shape[1]) / np.maximum(whole, np.finfo(float).tiny)


def modal_damping(
    mass: np.ndarray,
    stiffness: np.ndarray,
    damping: DampingRatio,
    parts: Sequence[tuple[np.ndarray, float]] = (),
) -> np.ndarray:
    """C = M Phi diag(2 zeta_k omega_k) Phi^T M of the modes of (K, M).

    Parameters
    ----------
    mass, stiffness : float (n, n), positive definite
    damping : zeta of all modes, or rows (Hz, zeta)
    parts : stiffness (n, n) and loss factor of every part with a separate one
    """
    if not len(mass):
        return np.zeros((0, 0))
    square, phi = la.eigh(stiffness, mass)
    omega = np.sqrt(np.maximum(square, 0.0))
    ratios = damping_ratios(damping, omega / (2.0 * math.pi))
    if parts:
        shares = energy_shares([part for part, _ in parts], phi, stiffness)
        ratios = ratios_with_parts(ratios, shares, [eta for _, eta in parts])
    weighted = mass @ phi
    return (weighted * (2.0 * ratios * omega)) @ weighted.T
