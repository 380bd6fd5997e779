"""Exponential integrator with a quadratic hold: exact for the linear part under forces held as polynomials of time.

Between two instants the nonlinear forces are the parabola through their values at both and at the instant before:
g(t_n + theta h) = sum_k c_k theta^k. With phi_k(z) = int_0^1 e^((1 - s) z) s^(k-1)/(k-1)! ds and z = lambda h,

    eta_new = e^z eta + h sum_k k! phi_(k+1)(z) c_k = e^z eta + sum_s w_s g_(n+1-s),

an implicit exponential Adams method of third order in the nonlinear forces. After the start, and after a contact has
opened or closed, the earlier value does not apply to the step, and the hold is the straight line between both ends.
Steps in which this approximation of the forces is too coarse are cut into quarters, up to three times (see
`mbd.integrators.modal_loop`).

References
----------
Hochbruck & Ostermann (2010), Acta Numerica 19, 209-286, sections 2.1 and 2.5.
"""

from __future__ import annotations

import math

import numpy as np

from mbd.integrators.modal import Hold, ModalIntegrator
from mbd.integrators.phi_functions import phi_functions
from mbd.system.system import System

LINEAR = (1.0, 0.0)  # theta of the instants whose forces define a hold
QUADRATIC = (1.0, 0.0, -1.0)
AFTER_SHORT, AFTER_LONG = (1.0, 0.0, -0.25), (1.0, 0.0, -4.0)  # the last step was a quarter as long, four times as long
LEVELS = 4  # step lengths h, h/4, h/16, h/64


def hold(eigenvalues: np.ndarray, step: float, instants: tuple[float, ...] = QUADRATIC) -> Hold:
    """Weights of the polynomial through the forces at ``instants`` (theta), of which the new one is the first."""
    z, n = eigenvalues * step, len(instants)
    phi = phi_functions(z, n)
    powers = np.linalg.inv(np.vander(np.array(instants), increasing=True))
    moments = np.array([math.factorial(k) * phi[k + 1] for k in range(n)])
    return Hold(growth=phi[0], weights=step * powers.T @ moments, constant=step * phi[1], powers=powers)


def exponential(system: System, step: float) -> ModalIntegrator:
    """Integrator with a quadratic hold of the nonlinear forces and local refinement of the step."""

    def holds(values: np.ndarray, h: float) -> list[Hold]:
        return [hold(values, h, instants) for instants in (LINEAR, QUADRATIC, AFTER_SHORT, AFTER_LONG)]

    return ModalIntegrator(system, step, holds, levels=LEVELS, exact=True)
