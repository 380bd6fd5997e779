"""Natural modes of reduced matrices: with springs, without damping, and the names of modal coordinates."""

from __future__ import annotations

import math

import numpy as np
import scipy.linalg as la


def undamped_modes(stiffness: np.ndarray, mass: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Natural frequencies (Hz), ascending, and shapes (coordinate, mode), orthonormal in the mass."""
    square, shapes = la.eigh(stiffness, mass)
    return np.sqrt(np.maximum(square, 0.0)) / (2.0 * math.pi), shapes


def on_springs(stiffness: np.ndarray, springs: np.ndarray) -> np.ndarray:
    """Stiffness with springs (b,), N/m, added at its first coordinates."""
    return stiffness + np.diag(np.append(springs, np.zeros(len(stiffness) - len(springs))))


def mode_names(n_fixed: int, count: int) -> tuple[str, ...]:
    """Names of `count` modes: `n_fixed` fixed-interface modes, then inertia corrections."""
    return tuple(f"mode_{i + 1}" if i < n_fixed else f"inertia_{i + 1 - n_fixed}" for i in range(count))
