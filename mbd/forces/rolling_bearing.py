"""Rolling bearing: Hertz contacts of every ball or roller between two rigid rings, in a cage that turns.

With u = (ux, uy, uz, rx, rz) of the inner against the outer ring, at an element at the cage angle theta
(x = cos theta, z = sin theta) the radial and axial shifts of the inner raceway are

    rho = ux cos theta + uz sin theta      w = uy + R g      g = rz cos theta - rx sin theta      R = pitch radius.

Ball (Jones, Harris): the distance A = (f_i + f_o - 1) D of the groove centres changes to
sqrt((A cos a - P/2 + rho)^2 + (A sin a + p + w)^2) = A + delta, and Q = K delta^1.5 along their line; P is the
diametral clearance, p an axial preload shift. K is that of `mbd.parts.rolling_elements`.

Roller: delta = (rho - P/2) cos a + (w + p) sin a - g s at the place s of a lamina along its length l, and
q = c_L l^(8/9) delta^(10/9) per roller, c_L = 35 948 N/mm^(10/9) mm^(-8/9) for steel (both contacts), in ``LAMINAE``
laminae of equal length. Crowned ends are not modelled.

The forces follow from the potential sum of 2/5 K delta^2.5 (9/19 for rollers), so that a bearing at rest conserves
energy. The cage turns at (1 - gamma)/2 of the shaft, gamma = D cos a/(2 R), without slip and by the angle
of the train alone: the number of elements under load varies with it (varying compliance). With damping each contact
carries max(0, Q + tau dQ/d delta delta'), delta' by the motion u' alone. Not modelled: centrifugal and gyroscopic
forces of the elements, lubricant film.

References
----------
Harris & Kotzalas (2007), Rolling Bearing Analysis, 5th ed., ch. 7 (loads); ISO/TS 16281:2008, 4.2 and 4.3 (laminae).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.numerics.inner_functions import UNCOUNTED, inner
from fem.numerics.root_finding import brentq
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import BY_ANGLE, ENERGY, Element, Rule, Signal, rule
from mbd.elements.rule_call import evaluated
from mbd.parts.bearings import BEARING_AXES, BearingSpec, bearing_force
from mbd.parts.rolling_elements import RollingElements, pass_frequencies, reference_load

LAMINAE = 5
ROLLER_EXPONENT = 10 / 9
COUNT, K, RADIUS, RATE, START, TAU, FIRST = range(7)  # numbers of both rules; those of one rule follow from FIRST on


@rule(__file__, **UNCOUNTED, fastmath={"contract"})
def ball_rule(values, motion, answer):
    """Force of a ball bearing on the rows ux uy uz rx rz of the inner against the outer ring."""
    u, v = motion.u, motion.v
    count, k = int(values[COUNT]), values[K]
    radius, tau = values[RADIUS], values[TAU]
    centre, a_r, a_a = values[FIRST], values[FIRST + 1], values[FIRST + 2]
    energy, turned = 0.0, 0.0
    spacing = 2.0 * math.pi / count
    start = values[START] - values[RATE] * motion.angle
    c, s = math.cos(start), math.sin(start)
    step_c, step_s = math.cos(spacing), math.sin(spacing)
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
            damp = tau * slope
            loss = damp * rate
            if q + loss <= 0.0:
                loss, damp = -q, 0.0
            energy += 0.4 * q * delta
            turned += q * (n_r * (u[2] * c - u[0] * s) - n_a * radius * (u[4] * s + u[3] * c))
            _push(answer.elastic, c, s, q * n_r, q * n_a, q * n_a * radius)
            _push(answer.lost, c, s, loss * n_r, loss * n_a, loss * n_a * radius)
            side = q / length
            k_rr = slope * n_r * n_r + side * n_a * n_a
            k_ra = (slope - side) * n_r * n_a
            k_aa = slope * n_a * n_a + side * n_r * n_r
            _spread(answer.stiffness, c, s, radius, k_rr, k_ra, k_aa)
            _spread(answer.lost_by_v, c, s, radius, damp * n_r * n_r, damp * n_r * n_a, damp * n_a * n_a)
        c, s = c * step_c - s * step_s, s * step_c + c * step_s
    _mirror(answer.stiffness)
    _mirror(answer.lost_by_v)
    answer.log[ENERGY], answer.log[BY_ANGLE] = energy, -values[RATE] * turned


@rule(__file__, **UNCOUNTED, fastmath={"contract"})
def roller_rule(values, motion, answer):
    """Force of a roller bearing on the rows ux uy uz rx rz of the inner against the outer ring."""
    u, v = motion.u, motion.v
    count, k = int(values[COUNT]), values[K]
    radius, tau = values[RADIUS], values[TAU]
    length, n_r, n_a, back = values[FIRST], values[FIRST + 1], values[FIRST + 2], values[FIRST + 3]
    energy, turned = 0.0, 0.0
    spacing = 2.0 * math.pi / count
    start = values[START] - values[RATE] * motion.angle
    for e in range(count):
        c, s = math.cos(start + e * spacing), math.sin(start + e * spacing)
        g = u[4] * c - u[3] * s
        middle = n_r * (u[0] * c + u[2] * s) + n_a * (u[1] + radius * g) - back
        if middle + 0.5 * length * abs(g) <= 0.0:
            continue
        spin = v[4] * c - v[3] * s
        rate = n_r * (v[0] * c + v[2] * s) + n_a * (v[1] + radius * spin)
        q, q_s, p, p_s = 0.0, 0.0, 0.0, 0.0  # normal force and its moment about mid length: elastic; damping
        k0, k1, k2, d0, d1, d2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for m in range(LAMINAE):
            place = ((m + 0.5) / LAMINAE - 0.5) * length
            delta = middle - g * place
            if delta <= 0.0:
                continue
            slope = ROLLER_EXPONENT * k / LAMINAE * math.exp(math.log(delta) / 9.0)
            elastic = slope * delta / ROLLER_EXPONENT
            closing = rate - spin * place
            damp = tau * slope
            loss = damp * closing
            if elastic + loss <= 0.0:
                loss, damp = -elastic, 0.0
            energy += elastic * delta * 9.0 / 19.0
            turned += elastic * (n_r * (u[2] * c - u[0] * s) - (n_a * radius - place) * (u[4] * s + u[3] * c))
            q += elastic
            q_s -= elastic * place
            p += loss
            p_s -= loss * place
            k0 += slope
            k1 -= slope * place
            k2 += slope * place * place
            d0 += damp
            d1 -= damp * place
            d2 += damp * place * place
        _push(answer.elastic, c, s, q * n_r, q * n_a, q * n_a * radius + q_s)  # the radius adds to the lever arm of g
        _push(answer.lost, c, s, p * n_r, p * n_a, p * n_a * radius + p_s)
        _spread_line(answer.stiffness, c, s, radius, n_r, n_a, k0, k1, k2)
        _spread_line(answer.lost_by_v, c, s, radius, n_r, n_a, d0, d1, d2)
    _mirror(answer.stiffness)
    _mirror(answer.lost_by_v)
    answer.log[ENERGY], answer.log[BY_ANGLE] = energy, -values[RATE] * turned


@inner(fastmath={"contract"})
def _push(force, c, s, radial, axial, tilting):
    """Add a force along rho and w, and a moment on g, of one element."""
    force[0] += radial * c
    force[1] += axial
    force[2] += radial * s
    force[3] -= tilting * s
    force[4] += tilting * c


@inner(fastmath={"contract"})
def _spread(matrix, c, s, radius, rr, ra, aa):
    """Add rr, ra, aa on (rho, w) of one element to the upper triangle over (ux uy uz rx rz)."""
    gx, gz = -radius * s, radius * c  # dw/drx, dw/drz
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
    lever = (0.0, 0.0, 0.0, -s, c)
    for i in range(5):
        for j in range(i, 5):
            matrix[i, j] += (
                k0 * row[i] * row[j] + k1 * (row[i] * lever[j] + lever[i] * row[j]) + k2 * lever[i] * lever[j]
            )


@inner()
def _mirror(matrix):
    for i in range(5):
        for j in range(i):
            matrix[i, j] = matrix[j, i]


def element_values(elements: RollingElements, rate: float, damping_time: float) -> np.ndarray:
    """Numbers of `ball_rule` or `roller_rule`; ``rate`` is the cage angle (about +y) per motor angle."""
    e, a = elements, elements.contact_angle
    half = e.clearance / 2
    common = [e.count, e.stiffness, e.pitch_diameter / 2, rate, e.cage_start, damping_time]
    if e.kind == "ball":
        centre = (e.inner_conformity + e.outer_conformity - 1) * e.diameter
        return np.array([*common, centre, centre * math.cos(a) - half, centre * math.sin(a) + e.preload])
    return np.array([*common, e.length, math.cos(a), math.sin(a), half * math.cos(a) - e.preload * math.sin(a)])


@dataclass(frozen=True, kw_only=True)
class RollingContacts:
    """Rolling contacts of a bearing, with their damping time ``damping_time`` tau (s)."""

    elements: RollingElements
    damping_time: float = 0.0

    @property
    def rule(self) -> Rule:
        """Rule for balls or for rollers."""
        return ball_rule if self.elements.kind == "ball" else roller_rule

    def values(self, rate: float) -> np.ndarray:
        """Numbers of the rule; ``rate`` is the cage angle (about +y) per motor angle."""
        return element_values(self.elements, rate, self.damping_time)

    def element(self, lay: Coordinates, bearing: BearingSpec) -> Element:
        """Force of the bearing; ``bearing`` gives the linear reference."""
        cage = lay.sense(bearing.shaft) * lay.ratios[bearing.shaft] * pass_frequencies(self.elements).cage
        load, arm = reference_load(self.elements), self.elements.pitch_diameter / 2
        axes = np.eye(len(BEARING_AXES))
        return Element(
            kind="rolling bearing",
            name=bearing.name,
            part=bearing.name,
            words=bearing.words,
            rule=self.rule,
            values=self.values(cage),
            rows=bearing.rows(lay),
            row_names=BEARING_AXES,
            scale=(load, load, load, load * arm, load * arm),
            inner_contacts=True,
            stiffness=bearing.stiffness,
            damping=tuple(bearing.damping_time * k for k in bearing.stiffness),
            signals=tuple(
                Signal(bearing_force(bearing.name, name[1]), "N", force=tuple(axes[i]))
                for i, name in enumerate(BEARING_AXES)
                if name.startswith("u")
            ),
        )


def hertz_bearing(
    name: str, shaft: str, y: float, elements: RollingElements, damping_time: float,
    support: Literal["casing", "ground"] = "casing",
) -> BearingSpec:  # fmt: skip
    """Bearing with rolling elements; its linear reference is the tangent stiffness at `reference_load`.

    Parameters
    ----------
    name, shaft : names of the bearing and of the shaft in it
    y : m, place on the shaft
    elements : the rolling elements and their races
    damping_time : damping divided by stiffness, s
    support : what carries the outer ring
    """
    radial, axial, tilt = tangent_at_load(elements)
    return BearingSpec(
        name=name, shaft=shaft, y=y, stiffness=(radial, axial, radial, tilt, tilt), damping_time=damping_time,
        support=support, model="hertz",
        inside=RollingContacts(elements=elements, damping_time=damping_time),
    )  # fmt: skip


def response(elements: RollingElements, u: np.ndarray, cage: float = 0.0) -> tuple[np.ndarray, np.ndarray, float]:
    """Force (5,) against the displacement u = (ux, uy, uz, rx, rz), its tangent (5, 5) and the potential, at rest."""
    contacts = RollingContacts(elements=elements)
    found = evaluated(contacts.rule, contacts.values(-1.0), u, angle=cage)
    return found.elastic, found.stiffness[:, :5], float(found.log[ENERGY])


def tangent_at_load(elements: RollingElements) -> tuple[float, float, float]:
    """Radial, axial and tilt stiffness under `reference_load`, axially held, for the linear reference."""
    load = reference_load(elements)

    def short(depth: float) -> float:
        return float(response(elements, np.array([depth, 0.0, 0.0, 0.0, 0.0]))[0][0]) - load

    high = 1e-6
    while short(high) < 0.0:
        high *= 2.0
    depth = float(brentq(short, -high, high)) if short(-high) < 0.0 else 0.0
    stiff = response(elements, np.array([depth, 0.0, 0.0, 0.0, 0.0]))[1]
    return float(stiff[0, 0] + stiff[2, 2]) / 2, float(stiff[1, 1]), float(stiff[3, 3] + stiff[4, 4]) / 2
