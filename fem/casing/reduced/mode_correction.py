"""Stiffness of a reduced body with corrected natural frequencies.

With the natural modes Phi of a body, K Phi = M Phi Omega^2 and Phi^T M Phi = I, and the ratios r of their corrected
frequencies to Omega, let

    A = r_m (I + Phi (diag(r/r_m) - I) Phi^T M),    r_m the mean of r.

Then K' = A^T K A has the modes Phi with the frequencies r Omega, and r_m^2 times the stiffness of all others. Mass and
shapes are unchanged. Rigid motions are orthogonal to Phi and remain without force. A part K_p of K becomes A^T K_p A,
so that the parts sum to K'. As K' = K A^2, forces R q on the ground become R A^2 q: at rest they are unchanged under
given loads.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg as la


def corrected_motion(stiffness: np.ndarray, mass: np.ndarray, ratios: np.ndarray, first: int) -> np.ndarray:
    """The matrix A (n, n).

    Parameters
    ----------
    stiffness, mass : (n, n) of the body without mounts
    ratios : (mode,) corrected over computed frequencies of the lowest modes; none if it is empty
    first : number of rigid motions below these modes
    """
    if not len(ratios):
        return np.eye(len(mass))
    last = min(first + len(ratios), len(mass))
    _, shapes = la.eigh(stiffness, mass, subset_by_index=(first, last - 1))
    mean = float(ratios.mean())
    change = ratios[: last - first] - mean
    return mean * np.eye(len(mass)) + shapes @ (change[:, None] * (shapes.T @ mass))
