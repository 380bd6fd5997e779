"""Ground under a container: a vertical contact force, without friction.

The height g of the ground and the lift z of the container are relative to its place at t = 0 with the rope just taut.
The force is F = max(0, k s + c s') for s = g - z > 0, where z contains the rolling of the train.
"""

from __future__ import annotations

from dataclasses import dataclass

from mbd.elements.coordinates import Coordinates
from mbd.elements.element import ENERGY, Element, rule
from mbd.elements.mode_words import ModeWords

STIFFNESS, DAMPING, LEVEL, RISE = range(4)


@rule(__file__)
def ground_rule(values, motion, answer):
    """Force on the lift (m) of the container."""
    s = values[LEVEL] - motion.u[0] - values[RISE] * motion.angle
    if s <= 0.0:
        return
    k, c = values[STIFFNESS], values[DAMPING]
    rate = -motion.v[0] - values[RISE] * motion.speed
    elastic = k * s
    answer.elastic[0], answer.stiffness[0, 0], answer.log[ENERGY] = -elastic, k, 0.5 * elastic * s
    if elastic + c * rate > 0.0:
        answer.lost[0], answer.lost_by_v[0, 0] = -c * rate, c
    else:
        answer.lost[0], answer.lost_by_u[0, 0] = elastic, -k


@dataclass(frozen=True, kw_only=True)
class Ground:
    """Ground under the container: ``level`` (m) over the place of the just taut rope, N/m, damping ratio of the
    container on it."""

    level: float
    stiffness: float
    damping_ratio: float = 0.1

    def element(self, lay: Coordinates, lift: str, mass: float, rise: float) -> Element:
        """The ground under a container.

        Parameters
        ----------
        lay : coordinates of the machine
        lift : name of the coordinate of the container, which rises along it, m
        mass : of the container, kg
        rise : of the container by the rolling of the train, m per radian of the motor
        """
        damping = 2 * self.damping_ratio * (self.stiffness * mass) ** 0.5
        return Element(
            kind="ground",
            name="ground",
            part="ground",
            words=ModeWords("ground", "ground", always=True),
            rule=ground_rule,
            values=(self.stiffness, damping, self.level, rise),
            rows=lay.own_row(lift)[None],
            row_names=("lift",),
            scale=(max(mass * lay.gravity, 1.0),),
            inner_contacts=True,
            rolls=True,
        )
