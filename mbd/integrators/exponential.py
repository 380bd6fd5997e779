"""Exponential integrator with a first-order hold: exact for the linear part under a piecewise linear force.

eta_new = e^z eta + h [(phi_1 - phi_2) g_old + phi_2 g_new], z = lambda h, phi_1 = (e^z - 1)/z,
phi_2 = (e^z - 1 - z)/z^2. Second order in the nonlinear forces. With undamped modes and a contact that opens, the
step must stay below half the period of a mode that lives on the contact alone.

References
----------
Hochbruck & Ostermann (2010), Acta Numerica 19, 209-286.
"""

from __future__ import annotations

import numpy as np

from mbd.integrators.modal import ModalIntegrator
from mbd.system import System

SERIES_BELOW = 0.5
SERIES_TERMS = 18


def coefficients(eigenvalues: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """E, a, b of eta_new = E eta + a g_old + b g_new."""
    z = eigenvalues * step
    phi_1, phi_2 = phi_functions(z)
    return np.exp(z), step * (phi_1 - phi_2), step * phi_2


def phi_functions(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """phi_1 and phi_2 at complex ``z``; by their series near 0, where the closed forms cancel."""
    small = abs(z) < SERIES_BELOW
    series = np.where(small, z, 0.0)
    one, two = np.zeros_like(series), np.zeros_like(series)
    for k in range(SERIES_TERMS, -1, -1):
        one, two = 1.0 + one * series / (k + 2), 1.0 + two * series / (k + 3)
    two = two / 2
    large = np.where(small, 1.0, z)
    return (
        np.where(small, one, (np.exp(large) - 1) / large),
        np.where(small, two, (np.exp(large) - 1 - large) / large**2),
    )


def exponential(system: System, step: float) -> ModalIntegrator:
    """Integrator with a first-order hold of the nonlinear forces."""
    return ModalIntegrator(system, step, coefficients, linear_forces=True)
