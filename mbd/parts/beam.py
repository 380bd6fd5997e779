"""Beam section and rigid disk: pieces of a shaft, on the displacements (ux, uy, uz, rx, ry, rz) of its nodes.

A section of length L along y carries axial and torsional stiffness EA/L, GJ/L and, in the two planes (uz, rx) and
(ux, -rz), the shear-flexible beam with interdependent shape functions (exact for end loads), consistent mass and rotary
inertia. Material damping is C = tau K.

What turns at Omega about +y has gyroscopic moments -Omega G u', G skew. The momentum J_p Omega (-rz, 1, rx) of a tilted
disk asks for the moments M_x = -J_p Omega rz', M_z = J_p Omega rx': G has -J_p in (rx, rz) and J_p in (rz, rx). A beam
section spreads 2 rho I over its length as its rotary inertia is spread, in the same shape functions. G does no work.
The torque by a change of speed on a tilted disk, J_p Omega' times the tilt, is neglected.

References
----------
Przemieniecki (1968), Theory of Matrix Structural Analysis, sections 5.6 and 11.6 (stiffness and mass of the beam);
Friedman & Kosmatka (1993), Computers & Structures 47(3), 473-481 (shape functions);
Cowper (1966), J. Appl. Mech. 33(2), 335-340 (shear coefficient of the hollow circle);
Nelson (1980), J. Mech. Des. 102(4), 793-803; Genta (2005), Dynamics of Rotating Systems, 4.5 (gyroscopic moments).
"""

from __future__ import annotations

import math

import numpy as np

Z_PLANE, X_PLANE = (2, 3, 8, 9), (0, 5, 6, 11)  # (uz, rx) and (ux, rz) of both nodes
X_SIGNS = (1, -1, 1, -1)  # theta = du/dy is -rz


def beam_matrices(
    length: float, outer: float, inner: float, *, modulus: float, nu: float, density: float, damping_time: float
) -> np.ndarray:
    """A length (m) of hollow round shaft on the displacements (12,) of its two nodes.

    Parameters
    ----------
    length, outer, inner : of the section and its diameters, m
    modulus, nu : Young's modulus, Pa, and Poisson's ratio
    density, damping_time : kg/m3, and tau of C = tau K, s

    Returns
    -------
    M, C, K and G (4, 12, 12), SI
    """
    area = math.pi * (outer**2 - inner**2) / 4
    second_moment = math.pi * (outer**4 - inner**4) / 64  # the polar moment is twice that
    kappa = shear_coefficient(nu, inner / outer)
    phi = 12 * 2 * (1 + nu) * (outer**2 + inner**2) / 16 / (kappa * length**2)  # 12 E I/(kappa G A L^2)
    mass, stiffness, gyroscopic = np.zeros((3, 12, 12))
    spread = np.array([[2, 1], [1, 2]]) * length / 6
    mass[np.ix_((1, 7), (1, 7))] = density * area * spread
    mass[np.ix_((4, 10), (4, 10))] = density * 2 * second_moment * spread
    mass += _in_both_planes(_bending(length, phi, 0.0, density * area, density * second_moment)[0])
    between = np.array([[1, -1], [-1, 1]]) / length
    stiffness[np.ix_((1, 7), (1, 7))] = modulus * area * between
    stiffness[np.ix_((4, 10), (4, 10))] = modulus / (2 * (1 + nu)) * (2 * second_moment) * between
    stiffness += _in_both_planes(_bending(length, phi, modulus * second_moment, 0.0, 0.0)[1])
    block = 2.0 * _bending(length, phi, 0.0, 0.0, density * second_moment)[0] @ np.diag(X_SIGNS)
    gyroscopic[np.ix_(Z_PLANE, X_PLANE)] = block
    gyroscopic[np.ix_(X_PLANE, Z_PLANE)] = -block.T
    return np.stack([mass, damping_time * stiffness, stiffness, gyroscopic])


def disk_matrices(mass: float, polar_inertia: float, diametral_inertia: float) -> np.ndarray:
    """M = diag(m, m, m, J_d, J_p, J_d), C, K and G (4, 6, 6) of a disk (kg, kg m2) on a node."""
    found = np.zeros((4, 6, 6))
    found[0] = np.diag((mass,) * 3 + (diametral_inertia, polar_inertia, diametral_inertia))
    found[3, 3, 5], found[3, 5, 3] = -polar_inertia, polar_inertia
    return found


def shear_coefficient(nu: float, m: float) -> float:
    """Cowper's kappa of a circle with the bore ratio m = d_i/d_o."""
    q = (1 + m * m) ** 2
    return 6 * (1 + nu) * q / ((7 + 6 * nu) * q + (20 + 12 * nu) * m * m)


def _in_both_planes(bending: np.ndarray) -> np.ndarray:
    """(12, 12) of a matrix (4, 4) over (v1, theta1, v2, theta2)."""
    matrix = np.zeros((12, 12))
    matrix[np.ix_(Z_PLANE, Z_PLANE)] = bending
    matrix[np.ix_(X_PLANE, X_PLANE)] = bending * np.outer(X_SIGNS, X_SIGNS)
    return matrix


def _bending(length: float, phi: float, ei: float, rho_a: float, rho_i: float) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness (4, 4) in (v1, theta1, v2, theta2) with theta = dv/dy for a slender beam."""
    mu = 1 / (1 + phi)
    k = np.array([[12, 6, -12, 6], [6, 4 + phi, -6, 2 - phi], [-12, -6, 12, -6], [6, 2 - phi, -6, 4 + phi]])
    scale = np.array([1, length, 1, length])
    stiffness = ei * mu / length**3 * k * np.outer(scale, scale)
    points, weights = np.polynomial.legendre.leggauss(4)  # exact to degree 7, the product has degree 6
    mass = np.zeros((4, 4))
    for s, w in zip(0.5 * (points + 1), 0.5 * length * weights, strict=True):
        bubble = s - s * s
        v = mu * np.array(
            [
                1 - 3 * s**2 + 2 * s**3 + phi * (1 - s),
                length * (s - 2 * s**2 + s**3 + phi / 2 * bubble),
                3 * s**2 - 2 * s**3 + phi * s,
                length * (-(s**2) + s**3 - phi / 2 * bubble),
            ]
        )
        theta = mu * np.array(
            [
                -6 / length * bubble,
                1 - 4 * s + 3 * s**2 + phi * (1 - s),
                6 / length * bubble,
                -2 * s + 3 * s**2 + phi * s,
            ]
        )
        mass += w * (rho_a * np.outer(v, v) + rho_i * np.outer(theta, theta))
    return mass, stiffness
