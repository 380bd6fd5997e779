"""Ground under a container: a vertical contact force, without friction.

The height g of the ground and the lift z of the container are relative to its place at t = 0 with the rope just taut.
The force is F = max(0, k s + c s') for s = g - z > 0, where z contains the rolling of the train.
"""

from __future__ import annotations

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


def ground(lay: Coordinates, lift: str, mass: float, values: tuple[float, float, float, float]) -> Element:
    """The ground under a container.

    Parameters
    ----------
    lay : coordinates of the machine
    lift : name of the coordinate of the container, which rises along it, m
    mass : of the container, kg
    values : stiffness (N/m), damping (N s/m), level over the place of the container on the just taut rope (m), and rise
        of the container by the rolling of the train (m per radian of the motor)
    """
    return Element(
        kind="ground",
        name="ground",
        part="ground",
        words=ModeWords("ground", "ground", always=True),
        rule=ground_rule,
        values=values,
        rows=lay.own_row(lift)[None],
        row_names=("lift",),
        scale=(max(mass * lay.gravity, 1.0),),
        inner_contacts=True,
        rolls=True,
    )
