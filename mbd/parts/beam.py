"""Beam section and rigid disk: the elements of a shaft, on the displacements (ux, uy, uz, rx, ry, rz) of its nodes.

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
from dataclasses import dataclass

import numpy as np

from mbd.elements.linear import LinearElement

Z_PLANE, X_PLANE = (2, 3, 8, 9), (0, 5, 6, 11)  # (uz, rx) and (ux, rz) of both nodes
X_SIGNS = (1, -1, 1, -1)  # theta = du/dy is -rz


@dataclass(frozen=True, eq=False, kw_only=True)
class BeamSection(LinearElement):
    """A length (m) of hollow round shaft on the displacements (12,) of its two nodes; Pa, kg/m3, s."""

    length: float
    outer_diameter: float
    inner_diameter: float
    elastic_modulus: float
    poisson_ratio: float
    density: float
    damping_time: float

    def mass(self) -> np.ndarray:
        """M (12, 12), kg, kg m and kg m2."""
        pair = np.array([[2, 1], [1, 2]]) * self.length / 6
        matrix = np.zeros((12, 12))
        matrix[np.ix_((1, 7), (1, 7))] = self.density * self.area * pair
        matrix[np.ix_((4, 10), (4, 10))] = self.density * 2 * self.second_moment * pair
        mass_per_length = self.density * self.area, self.density * self.second_moment
        return matrix + _in_both_planes(_bending(self.length, self.shear_share, 0.0, *mass_per_length)[0])

    def stiffness(self) -> np.ndarray:
        """K (12, 12), N/m, N and N m."""
        pair = np.array([[1, -1], [-1, 1]]) / self.length
        shear_modulus = self.elastic_modulus / (2 * (1 + self.poisson_ratio))
        matrix = np.zeros((12, 12))
        matrix[np.ix_((1, 7), (1, 7))] = self.elastic_modulus * self.area * pair
        matrix[np.ix_((4, 10), (4, 10))] = shear_modulus * (2 * self.second_moment) * pair
        bending_stiffness = self.elastic_modulus * self.second_moment
        return matrix + _in_both_planes(_bending(self.length, self.shear_share, bending_stiffness, 0.0, 0.0)[1])

    def damping(self) -> np.ndarray:
        """C = tau K (12, 12)."""
        return self.damping_time * self.stiffness()

    def gyroscopic(self) -> np.ndarray:
        """G (12, 12), kg, kg m and kg m2."""
        tilt = _bending(self.length, self.shear_share, 0.0, 0.0, self.density * self.second_moment)[0]
        block = 2.0 * tilt @ np.diag(X_SIGNS)
        matrix = np.zeros((12, 12))
        matrix[np.ix_(Z_PLANE, X_PLANE)] = block
        matrix[np.ix_(X_PLANE, Z_PLANE)] = -block.T
        return matrix

    @property
    def area(self) -> float:
        """A of the cross section, m2."""
        return math.pi * (self.outer_diameter**2 - self.inner_diameter**2) / 4

    @property
    def second_moment(self) -> float:
        """I of the cross section, m4; the polar moment is twice that."""
        return math.pi * (self.outer_diameter**4 - self.inner_diameter**4) / 64

    @property
    def shear_share(self) -> float:
        """12 E I/(kappa G A L^2): shear over bending flexibility."""
        d, d_i = self.outer_diameter, self.inner_diameter
        kappa = shear_coefficient(self.poisson_ratio, d_i / d)
        return 12 * 2 * (1 + self.poisson_ratio) * (d**2 + d_i**2) / 16 / (kappa * self.length**2)


@dataclass(frozen=True, eq=False, kw_only=True)
class RigidDisk(LinearElement):
    """A disk (kg, kg m2) on the displacements (6,) of a node."""

    disk_mass: float
    polar_inertia: float
    diametral_inertia: float

    def mass(self) -> np.ndarray:
        """M (6, 6) = diag(m, m, m, J_d, J_p, J_d)."""
        return np.diag((self.disk_mass,) * 3 + (self.diametral_inertia, self.polar_inertia, self.diametral_inertia))

    def gyroscopic(self) -> np.ndarray:
        """G (6, 6)."""
        matrix = np.zeros((6, 6))
        matrix[3, 5], matrix[5, 3] = -self.polar_inertia, self.polar_inertia
        return matrix


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
