"""A reduced body in its natural modes: K Phi = M Phi diag(omega^2), Phi^T M Phi = I, Phi^T C Phi = diag(2 zeta omega).

Forces F on some coordinates displace them by Y F with the receptance Y =  Phi diag(1/(omega_k^2 - omega^2 + 2i zeta_k
omega_k omega)) Phi^T.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from fem.casing.reduced.reduced_body import ReducedBody


@dataclass(frozen=True, eq=False, kw_only=True)
class ModalForm:
    """Natural modes in SI, by ascending frequency."""

    squares: np.ndarray  # omega^2 (mode,), 1/s2
    ratios: np.ndarray  # zeta (mode,)
    shapes: np.ndarray  # Phi (coordinate, mode)

    @property
    def frequencies(self) -> np.ndarray:
        """Natural frequencies (mode,), Hz."""
        return np.sqrt(self.squares) / (2.0 * math.pi)


def modal_form(body: ReducedBody) -> ModalForm:
    """The natural modes of a body that is held or on springs; its damping must be modal.

    Raises
    ------
    ValueError : a body without coordinates or without support
    """
    if not len(body.mass):
        raise ValueError(f"casing {body.model}: has no coordinates and so no modes")
    squares, shapes = la.eigh(body.stiffness, body.mass)
    if squares[0] <= 0.0:
        raise ValueError(f"casing {body.model}: a motion without stiffness (omega^2 = {squares[0]:.3g} 1/s2)")
    damping = np.einsum("ck,cd,dk->k", shapes, body.damping, shapes, optimize=True)
    return ModalForm(squares=squares, ratios=damping / (2.0 * np.sqrt(squares)), shapes=shapes)
