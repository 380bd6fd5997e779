"""Rolling bearings: Hertz contacts of every ball or roller between two rigid rings, in a cage that turns.

With u = (ux, uy, uz, rx, rz) of the inner against the outer ring, an element at the cage angle theta (x = cos theta,
z = sin theta) sees the radial and axial shifts of the inner raceway

    rho = ux cos theta + uz sin theta      w = uy + R g      g = rz cos theta - rx sin theta      R = pitch radius.

Ball (Jones, Harris): the groove centres, A = (f_i + f_o - 1) D apart, move to the distance
sqrt((A cos a - P/2 + rho)^2 + (A sin a + p + w)^2) = A + delta, and Q = K delta^1.5 along their line; P is the
diametral clearance, p an axial preload shift. K is that of `mbd.rolling_elements`.

Roller: delta = (rho - P/2) cos a + (w + p) sin a - g s at the place s of a lamina along its length l, and
q = c_L l^(8/9) delta^(10/9) per roller, c_L = 35 948 N/mm^(10/9) mm^(-8/9) for steel (both contacts), in ``LAMINAE``
laminae of equal length. Crowned ends are not modelled.

The forces follow from the potential sum of 2/5 K delta^2.5 (9/19 for rollers), so that nothing is lost in a bearing
that does not turn. The cage turns at (1 - gamma)/2 of the shaft, gamma = D cos a/(2 R), without slip: the number of
elements under load varies with it (varying compliance). With damping each contact carries max(0, Q + tau dQ/d delta
delta'), delta' by the motion u' alone. No centrifugal or gyroscopic forces of the elements, no lubricant film.

References
----------
Harris & Kotzalas (2007), Rolling Bearing Analysis, 5th ed., ch. 7 (loads); ISO/TS 16281:2008, 4.2 and 4.3 (laminae).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from scipy import optimize

from fem.compiled import inner, sources, stored
from mbd.rolling_elements import RollingElements, element_values, reference_load

LAMINAE = 5
ROLLER_EXPONENT = 10 / 9


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
