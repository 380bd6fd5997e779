"""Trapezoidal rule: A-stable, second order, without numerical damping; equal to Newmark's average acceleration.

eta_new = [(1 + z/2) eta + (h/2)(g_old + g_new)]/(1 - z/2), z = lambda h. Its period error is (omega h)^2/12.

References
----------
Newmark (1959), J. Eng. Mech. Div. ASCE 85(3), 67-94; Hughes (1987), The Finite Element Method, section 9.1.
"""

from __future__ import annotations

import numpy as np

from mbd.integrators.modal import Hold, ModalIntegrator
from mbd.system.system import System


def hold(eigenvalues: np.ndarray, step: float) -> Hold:
    """Weights of the average of the forces at both ends."""
    half = eigenvalues * step / 2
    share = step / 2 / (1 - half)
    powers = np.array([[0.5, 0.5], [0.0, 0.0]])
    return Hold(growth=(1 + half) / (1 - half), weights=np.array([share, share]), constant=2 * share, powers=powers)


def trapezoidal(system: System, step: float) -> ModalIntegrator:
    """Integrator with the average of the forces at both ends."""
    return ModalIntegrator(system, step, lambda values, h: [hold(values, h)] * 4, levels=1, exact=False)
