"""Unbalance: a mass m at the radius e of a shaft, U = m e.

The mass and its inertia m e^2 belong to the shaft. The rest of its kinetic energy is T = U beta' v . t, v the
velocity of the axis in (x, z), n and t the turning directions of `mbd.excitations.turned_direction`; of its weight,
V = U g n_z. With a = v', t' = -beta' n, Lagrange's equations give the force on the axis and the torque about beta

    F = U (beta'^2 n - beta'' t),    Q = -U (a . t + g t_z),

the torque on the shaft in its lifting sense being -s Q. Their power is -(T + V)': the power from the motor to a
whirling shaft passes through Q, so that the works of a steady whirl cancel.

A force of `mbd.elements.element` cannot depend on accelerations. A seismic mass for each of phi, x and z measures them,
as in an accelerometer: m_s (w'' + 2 zeta omega w' + omega^2 w) = m_s a with w the motion of the shaft minus that of the
mass, so that a = omega^2 w + 2 zeta omega w' + O((f/f_s)^2). The mass is far lighter than any shaft and overdamped.
Only beta'' t and a . t are measured in this way; the centrifugal force is exact.

References
----------
Genta (2005), Dynamics of Rotating Systems, section 2.3 (Jeffcott rotor with varying speed).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.options import option
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import Element, rule
from mbd.elements.linear_part import Matrices, Part, part_on_rows, springs
from mbd.elements.mode_words import ModeWords
from mbd.excitations.turned_direction import turned_direction
from mbd.parts.load import TurningForce

WORDS = ModeWords("unbalance", "unbalances")
SEISMIC_INERTIAS = (1e-10, 1e-6, 1e-6)  # kg m2, kg, kg
SEISMIC_FREQUENCY = 2 * math.pi * 5e3  # rad/s
SEISMIC_DAMPING = 1.25  # ratio: it does not oscillate
FORCED = ("angle", "ux", "uz")
MEASURED = tuple(f"seismic {name}" for name in FORCED)
ACCELERATION, CENTRIFUGAL = 1e5, 1e6  # m/s2 and rad2/s2, for the scale of the forces
SIZE, START, SENSE, ROLL, GRAVITY = range(5)


@rule(__file__)
def unbalance_rule(values, motion, answer):
    """Forces on the angle, ux and uz of the shaft; the seismic rows, without forces, measure the accelerations."""
    size, s, u, v = values[SIZE], values[SENSE], motion.u, motion.v
    by_u, by_v = SEISMIC_FREQUENCY**2, 2.0 * SEISMIC_DAMPING * SEISMIC_FREQUENCY
    cos, sin = turned_direction(values[START], s, values[ROLL], motion.angle, u[0])
    rate = -s * (values[ROLL] * motion.speed + v[0])
    spin = -s * (by_u * u[3] + by_v * v[3])
    a_x, a_z = by_u * u[4] + by_v * v[4], by_u * u[5] + by_v * v[5] + values[GRAVITY]
    lost, lost_by_u, lost_by_v = answer.lost, answer.lost_by_u, answer.lost_by_v
    lost[0] = s * size * (a_x * sin - a_z * cos)
    lost[1] = -size * (rate * rate * cos + spin * sin)
    lost[2] = -size * (rate * rate * sin - spin * cos)
    lost_by_u[0, 0] = -size * (a_x * cos + a_z * sin)
    lost_by_u[1, 0] = s * size * (spin * cos - rate * rate * sin)
    lost_by_u[2, 0] = s * size * (spin * sin + rate * rate * cos)
    lost_by_v[1, 0] = 2.0 * s * size * rate * cos
    lost_by_v[2, 0] = 2.0 * s * size * rate * sin
    for slopes, slope in ((lost_by_u, by_u), (lost_by_v, by_v)):
        slopes[0, 4], slopes[0, 5] = s * size * sin * slope, -s * size * cos * slope
        slopes[1, 3], slopes[2, 3] = s * size * sin * slope, -s * size * cos * slope


@dataclass(frozen=True, eq=False, kw_only=True)
class Unbalance(TurningForce):
    """A rotating unbalance."""

    model: Literal["unbalance"] = "unbalance"
    size: float = option(unit="g mm", key="unbalance_g_mm", gt=0, text="mass times radius")
    angle: float = option(0.0, unit="deg", text="angle of the heavy spot at t = 0, from +x towards +z")

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Coordinates of the seismic masses."""
        return tuple(f"{self.name}:{word}" for word in FORCED)

    def rolling(self, ratios: Mapping[str, float]) -> np.ndarray:
        """The first seismic mass turns with the shaft."""
        return np.array([ratios[self.shaft], 0.0, 0.0])

    def translation(self) -> np.ndarray:
        """Motion of the seismic masses of x and z."""
        return np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])

    def parts(self, lay: Coordinates) -> Iterator[Part]:
        """The seismic masses."""
        own = self._own(lay)
        yield part_on_rows(
            own,
            name=f"{self.name}, seismic masses",
            words=WORDS,
            matrices=Matrices(mass=np.diag(SEISMIC_INERTIAS)),
        )
        yield part_on_rows(
            self._forced(lay) - own,
            name=f"{self.name}, seismic springs",
            words=WORDS,
            matrices=springs(
                SEISMIC_FREQUENCY**2 * np.array(SEISMIC_INERTIAS), 2 * SEISMIC_DAMPING / SEISMIC_FREQUENCY
            ),
        )

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """Force on the axis and torque on the shaft."""
        forced = self._forced(lay)
        yield Element(
            kind="unbalance",
            name=self.name,
            part=self.name,
            rule=unbalance_rule,
            values=(self.size, *self.direction(lay, self.angle), lay.gravity),
            rows=np.vstack([forced, forced - self._own(lay)]),
            row_names=(*FORCED, *MEASURED),
            scale=(self.size * ACCELERATION, *5 * (self.size * CENTRIFUGAL,)),
            rolls=True,
            in_matrix=True,
        )

    def _forced(self, lay: Coordinates) -> np.ndarray:
        """Rows (3, coordinate) of `FORCED`."""
        axes = lay.axis_row(self.shaft, self.y, 0), lay.axis_row(self.shaft, self.y, 2)
        return np.array([lay.angle_row(self.shaft, self.y), *axes])

    def _own(self, lay: Coordinates) -> np.ndarray:
        """Rows (3, coordinate) of the seismic masses."""
        return np.array([lay.own_row(name) for name in self.coordinates])
