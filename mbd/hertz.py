"""Rolling bearings: Hertz contacts of every ball or roller between two rigid rings, in a cage that turns.

With u = (ux, uy, uz, rx, rz) of the inner against the outer ring, an element at the cage angle theta (x = cos theta,
z = sin theta) sees the radial and axial shifts of the inner raceway

    rho = ux cos theta + uz sin theta      w = uy + R g      g = rz cos theta - rx sin theta      R = pitch radius.

Ball (Jones, Harris): the groove centres, A = (f_i + f_o - 1) D apart, move to the distance
sqrt((A cos a - P/2 + rho)^2 + (A sin a + p + w)^2) = A + delta, and Q = K delta^1.5 along their line; P is the
diametral clearance, p an axial preload shift. K joins both contacts, 1/K = (K_i^(-2/3) + K_o^(-2/3))^(3/2), by Hertz'
theory of elliptical contacts.

Roller: delta = (rho - P/2) cos a + (w + p) sin a - g s at the place s of a lamina along its length l, and
q = c_L l^(8/9) delta^(10/9) per roller, c_L = 35 948 N/mm^(10/9) mm^(-8/9) for steel (both contacts), in ``LAMINAE``
laminae of equal length. Crowned ends are not modelled.

The forces follow from the potential sum of 2/5 K delta^2.5 (9/19 for rollers), so that nothing is lost in a bearing
that does not turn. The cage turns at (1 - gamma)/2 of the shaft, gamma = D cos a/(2 R), without slip: the number of
elements under load varies with it (varying compliance). With damping each contact carries max(0, Q + tau dQ/d delta
delta'), delta' by the motion u' alone. No centrifugal or gyroscopic forces of the elements, no lubricant film.

References
----------
Harris & Kotzalas (2007), Rolling Bearing Analysis, 5th ed., ch. 6 (Hertz contacts), 7 (loads); ISO/TS 16281:2008, 4.2
and 4.3 (c_L, laminae); Brewe & Hamrock (1977), J. Lubr. Technol. 99, 485-487.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from scipy import optimize, special

from fem.compiled import inner, sources, stored
from mbd.checks import MachineError, finite, not_negative, positive

LAMINAE = 5
LINE_CONSTANT = 35948.0 * 1000.0 ** (10 / 9 + 8 / 9)  # c_L in N, m
BALL_EXPONENT, ROLLER_EXPONENT = 1.5, 10 / 9
STEEL = (206e9, 0.3)
REFERENCE_SHARE = 0.02


@dataclass(frozen=True, kw_only=True)
class RollingElements:
    """The inside of a rolling bearing, SI. ``contact_angle`` > 0 carries the shaft towards +y, < 0 towards -y."""

    kind: Literal["ball", "roller"]
    count: int
    diameter: float
    pitch_diameter: float
    contact_angle: float = 0.0
    length: float = 0.0  # of a roller
    inner_conformity: float = 0.52
    outer_conformity: float = 0.52
    clearance: float = 0.0  # diametral, radial direction
    preload: float = 0.0  # axial shift of the inner against the outer ring at assembly
    cage_start: float = 0.0  # rad

    def __post_init__(self) -> None:
        if self.kind not in ("ball", "roller"):
            raise MachineError(f"rolling elements: kind {self.kind!r} is unknown; known: ball, roller.")
        if self.count < 3:
            raise MachineError(f"rolling elements: {self.count} are too few; at least 3 hold a ring.")
        for name in ("diameter", "pitch_diameter"):
            positive(f"rolling elements {name}", getattr(self, name))
        for name in ("clearance", "preload", "cage_start"):
            finite(f"rolling elements {name}", getattr(self, name))
        room = self.pitch_diameter * math.sin(math.pi / self.count)
        if self.diameter > room:
            raise MachineError(
                f"rolling elements: {self.count} of diameter {self.diameter * 1e3:.3f} mm overlap on pitch diameter "
                f"{self.pitch_diameter * 1e3:.3f} mm; at most {room * 1e3:.3f} mm fit."
            )
        if abs(self.contact_angle) >= math.radians(75):
            raise MachineError(
                f"rolling elements: contact angle {math.degrees(self.contact_angle):.3g} deg must be below 75; thrust "
                "bearings are not modelled."
            )
        if self.kind == "roller":
            positive("rolling elements length", self.length, "A roller needs its effective contact length.")
        else:
            not_negative("rolling elements inner_conformity above 0.5", self.inner_conformity - 0.5 - 1e-6)
            not_negative("rolling elements outer_conformity above 0.5", self.outer_conformity - 0.5 - 1e-6)

    @property
    def gamma(self) -> float:
        """D cos a over the pitch diameter."""
        return self.diameter * math.cos(self.contact_angle) / self.pitch_diameter

    @property
    def stiffness(self) -> float:
        """K of one element, N/m^1.5 for a ball, N/m^(10/9) for a roller: both contacts in series."""
        if self.kind == "roller":
            return LINE_CONSTANT * self.length ** (8 / 9)
        d, g = self.diameter, self.gamma
        inner = ball_contact(2 / d, 2 / d, 2 * g / (d * (1 - g)), -1 / (self.inner_conformity * d))
        outer = ball_contact(2 / d, 2 / d, -2 * g / (d * (1 + g)), -1 / (self.outer_conformity * d))
        return float((inner ** (-2 / 3) + outer ** (-2 / 3)) ** -1.5)


def ball_contact(*curvatures: float) -> float:
    """K (N/m^1.5) in Q = K delta^1.5 of a steel contact; curvatures (1/m) of both bodies, in the rolling plane first:
    1 in rolling direction and across, 2 in rolling direction and across (hollow negative).

    The ratio kappa of the axes solves F(rho) = ((k^2 + 1) E - 2 F)/((k^2 - 1) E), F and E the complete elliptic
    integrals of 1 - 1/k^2; delta = delta* (3 Q/(2 sum E'))^(2/3) sum/2, delta* = (2 F/pi) (pi/(2 k^2 E))^(1/3).
    """
    one, across_one, two, across_two = curvatures
    total = sum(curvatures)
    star = dimensionless_deflection(abs((one - across_one) + (two - across_two)) / total)
    modulus, nu = STEEL
    soft = 3 / (2 * total) * 2 * (1 - nu**2) / modulus
    return float((star * soft ** (2 / 3) * total / 2) ** -1.5)


def dimensionless_deflection(difference: float) -> float:
    """delta* of the curvature difference F(rho) in [0, 1)."""
    if difference < 1e-9:
        return 1.0

    def miss(log_kappa: float) -> float:
        k2 = math.exp(2 * log_kappa)
        first, second = special.ellipk(1 - 1 / k2), special.ellipe(1 - 1 / k2)
        return ((k2 + 1) * second - 2 * first) / ((k2 - 1) * second) - difference

    k2 = math.exp(2 * optimize.brentq(miss, 1e-6, 12.0, xtol=1e-13))
    first, second = special.ellipk(1 - 1 / k2), special.ellipe(1 - 1 / k2)
    return float(2 * first / math.pi * (math.pi / (2 * k2 * second)) ** (1 / 3))


@dataclass(frozen=True)
class PassFrequencies:
    """Per revolution of the shaft with the outer ring at rest."""

    outer: float  # BPFO, elements passing a point of the outer ring
    inner: float  # BPFI
    spin: float  # BSF, turns of an element; a defect on it strikes twice as often
    cage: float  # FTF


def pass_frequencies(elements: RollingElements) -> PassFrequencies:
    """Kinematics without slip."""
    z, g = elements.count, elements.gamma
    spin = elements.pitch_diameter / (2 * elements.diameter) * (1 - g * g)
    return PassFrequencies(z / 2 * (1 - g), z / 2 * (1 + g), spin, (1 - g) / 2)


def element_values(elements: RollingElements, rate: float, damping_time: float) -> np.ndarray:
    """Constants for `ball_forces` or `roller_forces`; ``rate`` is the cage angle (about +y) per motor angle."""
    e, a = elements, elements.contact_angle
    half = e.clearance / 2
    common = [e.count, e.stiffness, e.pitch_diameter / 2, rate, e.cage_start, damping_time]
    if e.kind == "ball":
        centre = (e.inner_conformity + e.outer_conformity - 1) * e.diameter
        return np.array([*common, centre, centre * math.cos(a) - half, centre * math.sin(a) + e.preload])
    return np.array([*common, e.length, math.cos(a), math.sin(a), half * math.cos(a) - e.preload * math.sin(a)])


def reference_load(elements: RollingElements) -> float:
    """Radial load (N), a small share of the static capacity: 12 MPa Z D^2 of balls, 44 MPa Z D l of rollers."""
    across = elements.diameter if elements.kind == "ball" else elements.length
    capacity = (12e6 if elements.kind == "ball" else 44e6) * elements.count * elements.diameter * across
    return REFERENCE_SHARE * capacity * math.cos(elements.contact_angle)


def response(elements: RollingElements, u: np.ndarray, cage: float = 0.0) -> tuple[np.ndarray, np.ndarray, float]:
    """Force (5,) against the displacement u = (ux, uy, uz, rx, rz), its tangent (5, 5) and the potential, at rest."""
    values = np.zeros(10)
    own = element_values(elements, -1.0, 0.0)
    values[: len(own)] = own
    force, stiff, loss = np.zeros(5), np.zeros((5, 5)), np.zeros((5, 5))
    rule = ball_forces if elements.kind == "ball" else roller_forces
    energy = rule(values, cage, np.array(u, dtype=float), np.zeros(5), force, stiff, loss)[0]
    return force, stiff, float(energy)


def tangent_at_load(elements: RollingElements) -> tuple[float, float, float]:
    """Radial, axial and tilt stiffness under `reference_load`, axially held: a measure for the linear reference."""
    load = reference_load(elements)

    def short(depth: float) -> float:
        return float(response(elements, np.array([depth, 0.0, 0.0, 0.0, 0.0]))[0][0]) - load

    high = 1e-6
    while short(high) < 0.0:
        high *= 2.0
    depth = float(optimize.brentq(short, -high, high)) if short(-high) < 0.0 else 0.0
    stiff = response(elements, np.array([depth, 0.0, 0.0, 0.0, 0.0]))[1]
    return float(stiff[0, 0] + stiff[2, 2]) / 2, float(stiff[1, 1]), float(stiff[3, 3] + stiff[4, 4]) / 2


@stored(sources(Path(__file__)), fastmath={"contract"})
def ball_forces(values, angle, u, v, force, stiff, loss):
    """Force of a ball bearing on the shaft's rows times -1 (restoring, (5,)), tangents dF/du, dF/dv (5, 5).

    Rows ux uy uz rx rz. Returns the potential U, the power lost to damping, and dU/d angle at fixed u.
    """
    count, k = int(values[0]), values[1]
    radius, tau = values[2], values[5]
    centre, a_r, a_a = values[6], values[7], values[8]
    for i in range(5):
        force[i] = 0.0
        for j in range(5):
            stiff[i, j] = 0.0
            loss[i, j] = 0.0
    energy, power, turned = 0.0, 0.0, 0.0
    turn = 2.0 * math.pi / count
    start = values[4] - values[3] * angle
    c, s = math.cos(start), math.sin(start)
    step_c, step_s = math.cos(turn), math.sin(turn)
    for _ in range(count):
        x = a_r + u[0] * c + u[2] * s
        g = u[4] * c - u[3] * s
        y = a_a + u[1] + radius * g
        length = math.sqrt(x * x + y * y)
        delta = length - centre
        if delta > 0.0:
            n_r, n_a = x / length, y / length
            root = math.sqrt(delta)
            q = k * delta * root
            slope = 1.5 * k * root
            rate = n_r * (v[0] * c + v[2] * s) + n_a * (v[1] + radius * (v[4] * c - v[3] * s))
            total = q + tau * slope * rate
            energy += 0.4 * q * delta
            damp = tau * slope
            if total <= 0.0:
                total, damp = 0.0, 0.0
            power += (total - q) * rate
            turned += q * (n_r * (u[2] * c - u[0] * s) - n_a * radius * (u[4] * s + u[3] * c))
            p = total * n_r
            t = total * n_a
            force[0] += p * c
            force[1] += t
            force[2] += p * s
            force[3] -= t * radius * s
            force[4] += t * radius * c
            side = q / length
            k_rr = slope * n_r * n_r + side * n_a * n_a
            k_ra = (slope - side) * n_r * n_a
            k_aa = slope * n_a * n_a + side * n_r * n_r
            _spread(stiff, c, s, radius, k_rr, k_ra, k_aa)
            _spread(loss, c, s, radius, damp * n_r * n_r, damp * n_r * n_a, damp * n_a * n_a)
        c, s = c * step_c - s * step_s, s * step_c + c * step_s
    _mirror(stiff)
    _mirror(loss)
    return energy, power, -values[3] * turned


@stored(sources(Path(__file__)), fastmath={"contract"})
def roller_forces(values, angle, u, v, force, stiff, loss):
    """The same for a roller bearing."""
    count, k = int(values[0]), values[1]
    radius, tau = values[2], values[5]
    length, n_r, n_a, back = values[6], values[7], values[8], values[9]
    for i in range(5):
        force[i] = 0.0
        for j in range(5):
            stiff[i, j] = 0.0
            loss[i, j] = 0.0
    energy, power, turned = 0.0, 0.0, 0.0
    turn = 2.0 * math.pi / count
    start = values[4] - values[3] * angle
    for e in range(count):
        c, s = math.cos(start + e * turn), math.sin(start + e * turn)
        g = u[4] * c - u[3] * s
        middle = n_r * (u[0] * c + u[2] * s) + n_a * (u[1] + radius * g) - back
        if middle + 0.5 * length * abs(g) <= 0.0:
            continue
        spin = v[4] * c - v[3] * s
        rate = n_r * (v[0] * c + v[2] * s) + n_a * (v[1] + radius * spin)
        q, q_s, k0, k1, k2, d0, d1, d2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for m in range(LAMINAE):
            place = ((m + 0.5) / LAMINAE - 0.5) * length
            delta = middle - g * place
            if delta <= 0.0:
                continue
            slope = ROLLER_EXPONENT * k / LAMINAE * math.exp(math.log(delta) / 9.0)
            elastic = slope * delta / ROLLER_EXPONENT
            closing = rate - spin * place
            total, damp = elastic + tau * slope * closing, tau * slope
            if total <= 0.0:
                total, damp = 0.0, 0.0
            energy += elastic * delta * 9.0 / 19.0
            power += (total - elastic) * closing
            turned += elastic * (n_r * (u[2] * c - u[0] * s) - (n_a * radius - place) * (u[4] * s + u[3] * c))
            q += total
            q_s -= total * place
            k0 += slope
            k1 -= slope * place
            k2 += slope * place * place
            d0 += damp
            d1 -= damp * place
            d2 += damp * place * place
        # generalised: normal closing (q) and turning g (q_s); w adds radius to the arm of g
        force[0] += q * n_r * c
        force[1] += q * n_a
        force[2] += q * n_r * s
        arm = q * n_a * radius + q_s
        force[3] -= arm * s
        force[4] += arm * c
        _spread_line(stiff, c, s, radius, n_r, n_a, k0, k1, k2)
        _spread_line(loss, c, s, radius, n_r, n_a, d0, d1, d2)
    _mirror(stiff)
    _mirror(loss)
    return energy, power, -values[3] * turned


@inner(fastmath={"contract"})
def _spread(matrix, c, s, radius, rr, ra, aa):
    """Add rr, ra, aa on (rho, w) of one element to the upper triangle over (ux uy uz rx rz)."""
    gx, gz = -radius * s, radius * c  # w per rx, rz
    matrix[0, 0] += rr * c * c
    matrix[0, 1] += ra * c
    matrix[0, 2] += rr * c * s
    matrix[0, 3] += ra * c * gx
    matrix[0, 4] += ra * c * gz
    matrix[1, 1] += aa
    matrix[1, 2] += ra * s
    matrix[1, 3] += aa * gx
    matrix[1, 4] += aa * gz
    matrix[2, 2] += rr * s * s
    matrix[2, 3] += ra * s * gx
    matrix[2, 4] += ra * s * gz
    matrix[3, 3] += aa * gx * gx
    matrix[3, 4] += aa * gx * gz
    matrix[4, 4] += aa * gz * gz


@inner(fastmath={"contract"})
def _spread_line(matrix, c, s, radius, n_r, n_a, k0, k1, k2):
    """Add the stiffness of a line: delta = n_r rho + n_a w + (-place) g, moments k0, k1, k2 over -place."""
    row = (n_r * c, n_a, n_r * s, -radius * n_a * s, radius * n_a * c)
    turn = (0.0, 0.0, 0.0, -s, c)
    for i in range(5):
        for j in range(i, 5):
            matrix[i, j] += k0 * row[i] * row[j] + k1 * (row[i] * turn[j] + turn[i] * row[j]) + k2 * turn[i] * turn[j]


@inner()
def _mirror(matrix):
    for i in range(5):
        for j in range(i):
            matrix[i, j] = matrix[j, i]
