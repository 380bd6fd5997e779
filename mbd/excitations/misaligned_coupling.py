"""Coupling between misaligned shafts, with stiffness axes that turn with the first shaft; or a universal joint.

The axes e_1, e_2 are n and t of `mbd.excitations.turned_direction`. The axis of the second shaft lies ``offset`` from
that of the first and is tilted by ``tilt`` against it; with the motions u, r of both ends p = u_1 - u_2 - offset and
a = r_2 - r_1 + tilt, in turning components p_1, p_2 and a_1, a_2, the coupling stores

    U = (k_1 p_1^2 + k_2 p_2^2 + c_1 a_1^2 + c_2 a_2^2 + k_t w^2)/2,   w = phi_1 - phi_2 - s a_1 a_2/2 in a joint.

All forces and the torque on the rotation are its derivatives. With k_1 = k_2 and c_1 = c_2 the force of a fixed
misalignment is constant. With k_1 /= k_2 a force of (k_1 - k_2)/2 times the offset turns at twice the speed of the
shaft.

A universal joint turns by a_1 about one pin and by a_2 about the other. Rotations about two axes cause a third,
exp(a_1 e_1) exp(a_2 e_2) = exp(a_1 e_1 + a_2 e_2 + a_1 a_2 e_1 x e_2/2 + ...), so that phi_2 = phi_1 - s a_1 a_2/2: the
Cardan error alpha^2/4 sin 2 phi, of tan phi_2 = cos alpha tan phi_1 to second order in alpha. By virtual work a
transmitted torque T bends both shafts by T alpha/2 at twice the speed.

References
----------
Xu & Marangoni (1994), J. Sound Vib. 176(5), 663-679 and 681-691 (misaligned couplings as universal
joints: even multiples of the speed).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from mbd.elements.coordinates import Coordinates
from mbd.elements.element import ENERGY, Element, rule
from mbd.elements.linear_part import Part, part_on_rows, springs
from mbd.elements.mode_words import ModeWords
from mbd.excitations.turned_direction import turned_direction
from mbd.parts.couplings import CouplingWithAxes

WORDS = ModeWords("coupling", "couplings")
ROWS = ("angle", "twist", "rx", "rz", "ux", "uz")
LEAST_SCALE = 1e-3  # N and N m
START, SENSE, ROLL, TORSION, JOINT = range(5)
TILT, RADIAL, APART, OFF, LOSS = 5, 7, 9, 11, 13  # the first of two numbers each; LOSS: the first damping of the rows


@rule(__file__)
def coupling_rule(values, motion, answer):
    """Forces on the rows `ROWS`; all but the angle are relative to the second shaft."""
    s, torsion, half = values[SENSE], values[TORSION], 0.5 * values[SENSE] * values[JOINT]
    c_1, c_2, k_1, k_2 = values[TILT], values[TILT + 1], values[RADIAL], values[RADIAL + 1]
    u, elastic, stiffness = motion.u, answer.elastic, answer.stiffness
    cos, sin = turned_direction(values[START], s, values[ROLL], motion.angle, u[0])
    a_x, a_z = values[APART] - u[2], values[APART + 1] - u[3]
    p_x, p_z = u[4] - values[OFF], u[5] - values[OFF + 1]
    a_1, a_2, p_1, p_2 = a_x * cos + a_z * sin, a_z * cos - a_x * sin, p_x * cos + p_z * sin, p_z * cos - p_x * sin
    wound = u[1] - half * a_1 * a_2
    # gradient and second derivatives in turning components, then by beta
    by_1, by_2 = -half * a_2, -half * a_1
    g_1, g_2 = c_1 * a_1 + torsion * wound * by_1, c_2 * a_2 + torsion * wound * by_2
    h_11, h_22 = c_1 + torsion * by_1 * by_1, c_2 + torsion * by_2 * by_2
    h_12 = torsion * (by_1 * by_2 - half * wound)
    f_1, f_2 = k_1 * p_1, k_2 * p_2
    g_1b, g_2b = h_11 * a_2 - h_12 * a_1 - g_2, h_12 * a_2 - h_22 * a_1 + g_1
    f_1b, f_2b = k_1 * p_2 - f_2, f_1 - k_2 * p_1
    turning = g_1 * a_2 - g_2 * a_1 + f_1 * p_2 - f_2 * p_1
    elastic[0], elastic[1] = -s * turning, torsion * wound
    elastic[2], elastic[3] = g_2 * sin - g_1 * cos, -g_1 * sin - g_2 * cos
    elastic[4], elastic[5] = f_1 * cos - f_2 * sin, f_1 * sin + f_2 * cos
    stiffness[0, 0] = g_1b * a_2 - g_2b * a_1 + f_1b * p_2 - f_2b * p_1
    stiffness[0, 1] = -s * torsion * (by_1 * a_2 - by_2 * a_1)
    stiffness[0, 2], stiffness[0, 3] = s * (g_1b * cos - g_2b * sin), s * (g_1b * sin + g_2b * cos)
    stiffness[0, 4], stiffness[0, 5] = s * (f_2b * sin - f_1b * cos), -s * (f_1b * sin + f_2b * cos)
    stiffness[1, 1] = torsion
    stiffness[1, 2] = torsion * (by_2 * sin - by_1 * cos)
    stiffness[1, 3] = -torsion * (by_1 * sin + by_2 * cos)
    stiffness[2, 2] = h_11 * cos * cos - 2.0 * h_12 * cos * sin + h_22 * sin * sin
    stiffness[3, 3] = h_11 * sin * sin + 2.0 * h_12 * cos * sin + h_22 * cos * cos
    stiffness[2, 3] = (h_11 - h_22) * cos * sin + h_12 * (cos * cos - sin * sin)
    stiffness[4, 4] = k_1 * cos * cos + k_2 * sin * sin
    stiffness[5, 5] = k_1 * sin * sin + k_2 * cos * cos
    stiffness[4, 5] = (k_1 - k_2) * cos * sin
    for i in range(6):
        for j in range(i):
            stiffness[i, j] = stiffness[j, i]
        answer.lost[i] = values[LOSS + i] * motion.v[i]
        answer.lost_by_v[i, i] = values[LOSS + i]
    tilts = c_1 * a_1 * a_1 + c_2 * a_2 * a_2
    answer.log[ENERGY] = 0.5 * (tilts + k_1 * p_1 * p_1 + k_2 * p_2 * p_2 + torsion * wound * wound)


@dataclass(frozen=True, kw_only=True)
class MisalignedCoupling(CouplingWithAxes):
    """A coupling whose second shaft is displaced by ``offset`` (m, in x and z) and ``tilt`` (rad, about x and z).

    The first stiffness axis is at ``angle`` (rad) from +x towards +z when the first shaft is at the angle -``rolled``
    (rad, in its lifting sense).
    """

    rolled: float = 0.0

    def turned(self, turns: Mapping[str, float]) -> Self:
        """The coupling after its shafts have turned."""
        return replace(self, rolled=self.rolled + turns[self.shafts[0]])

    def parts(self, lay: Coordinates) -> Iterator[Part]:
        """The axial spring, whose direction does not turn."""
        if self.axial_stiffness > 0.0:
            yield part_on_rows(
                self._relative(lay, 1)[None],
                name=self.name,
                words=WORDS,
                matrices=springs(np.array([self.axial_stiffness]), self.damping_time),
            )

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """Radial, tilt and torsional forces, whose axes turn."""
        first = self.shafts[0]
        sense = float(lay.sense(first))
        tilt, radial = self.tilt_stiffness, self.radial_stiffness
        radial_across, tilt_across = self.across
        mean_tilt, mean_radial = (tilt + tilt_across) / 2, (radial + radial_across) / 2
        mean = (0.0, self.torsional_stiffness, mean_tilt, mean_tilt, mean_radial, mean_radial)
        damping = tuple(self.damping_time * k for k in mean)
        forces = 1e-3 * self.torsional_stiffness, 1e-3 * mean_tilt, 1e-6 * mean_radial  # at 1 mrad and 1 um
        torsional, bending, lateral = (max(force, LEAST_SCALE) for force in forces)
        yield Element(
            kind="misaligned coupling",
            name=f"{self.name}, turning",
            part=f"{self.name}, turning",
            words=WORDS,
            rule=coupling_rule,
            values=(
                self.angle - sense * self.rolled, sense, lay.ratios[first], self.torsional_stiffness, float(self.joint),
                tilt, tilt_across, radial, radial_across, *self.tilt, *self.offset,
                *damping,
            ),
            rows=np.vstack(
                [
                    lay.angle_row(first, self.y[0]),
                    sense * self._relative(lay, 4),
                    *(self._relative(lay, axis) for axis in (3, 5, 0, 2)),
                ]
            ),
            row_names=ROWS,
            scale=(torsional, torsional, bending, bending, lateral, lateral),
            stiffness=mean,
            damping=damping,
            rolls=True,
        )  # fmt: skip

    def _relative(self, lay: Coordinates, axis: int) -> np.ndarray:
        """Row of a displacement of the first end minus that of the second."""
        (one, other), (y_one, y_other) = self.shafts, self.y
        return lay.axis_row(one, y_one, axis) - lay.axis_row(other, y_other, axis)
