"""Container that swings on its ropes below a fixed trolley.

With L the free length in rigid rolling, e the vertical stretch row and (X, Y) the sway,

    d = sqrt((L + e)^2 + X^2 + Y^2)      s = d - L      F = max(0, k s + c s'),   k = EA/L per drum

pulls along the ropes; U = k s^2/2. Angles may be large. s is computed as (d^2 - L^2)/(d + L): the difference
of metres would have an error of 1e-15 m, 2e-12 of a light weight, too large for the search for the equilibrium. The
rate s' omits the contribution of L', which is (1 - cos of the angle) times the rope speed. Winding at constant speed
changes L slowly: the sway angle then grows as L^(-3/4) (adiabatic invariant E/omega of the pendulum).

Until t = 0 a force perpendicular to the ropes holds the container at its angle; then it is released.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.options import option
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import BY_ANGLE, ENERGY, Element, Signal, rule
from mbd.elements.reading import Reading
from mbd.forces.rope import LENGTH, LIFT, LOSS, PART, STIFFNESS_TIMES_LENGTH, TRAVEL, WORDS, Rope, RopeLoad
from mbd.parts.checks import MachineError
from mbd.parts.load import ROPE_FORCE, SWAY

SWAYS = ("container:sway_x", "container:sway_y")  # coordinates


@rule(__file__)
def pendulum_rule(values, motion, answer):
    """Force on (stretch, X, Y) of the ropes of one drum; ``values`` are those of `mbd.forces.rope`."""
    u, v = motion.u, motion.v
    length = values[LENGTH] - values[TRAVEL] * motion.angle
    k = values[STIFFNESS_TIMES_LENGTH] / length
    c = values[LOSS] * math.sqrt(k)
    depth = length + u[0]
    distance = math.sqrt(depth * depth + u[1] * u[1] + u[2] * u[2])
    s = (u[0] * (depth + length) + u[1] * u[1] + u[2] * u[2]) / (distance + length)  # d - L without cancellation
    if s <= 0.0:
        return
    n = (depth / distance, u[1] / distance, u[2] / distance)
    rate = n[0] * v[0] + n[1] * v[1] + n[2] * v[2]
    elastic = k * s
    pulls = elastic + c * rate > 0.0
    loss = c * rate if pulls else -elastic
    for i in range(3):
        answer.elastic[i], answer.lost[i] = elastic * n[i], loss * n[i]
        for j in range(3):
            along, across = n[i] * n[j], ((1.0 if i == j else 0.0) - n[i] * n[j]) / distance
            answer.stiffness[i, j] = k * along + elastic * across
            if pulls:
                answer.lost_by_u[i, j] = loss * across
                answer.lost_by_v[i, j] = c * along
            else:
                answer.lost_by_u[i, j] = -answer.stiffness[i, j]
    answer.log[ENERGY] = 0.5 * elastic * s
    answer.log[BY_ANGLE] = -values[TRAVEL] * (elastic * (n[0] - 1.0) - 0.5 * elastic * s / length)


@dataclass(frozen=True, kw_only=True)
class RopePendulumLoad(RopeLoad):
    """As rope, and the mass swings below a fixed trolley."""

    model: Literal["rope-pendulum"] = "rope-pendulum"  # type: ignore[assignment]
    sway_x: float = option(
        0.0,
        unit="deg",
        gt=-60,
        lt=60,
        text="angle of the ropes at t = 0 in the plane of x and z, released from rest",
    )
    sway_y: float = option(0.0, unit="deg", gt=-60, lt=60, text="angle of the ropes at t = 0 in the plane of y and z")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.ground_level is not None:
            raise MachineError("a swinging mass has no ground below it. Delete ground_level_m, or set model = 'rope'.")

    def on_drums(self, shaft: str, drums: tuple[float, ...]) -> RopePendulum:
        """The ropes with the swinging container; arguments as for `load`."""
        return RopePendulum(shaft=shaft, drums=drums, hoist=self)


@dataclass(frozen=True, kw_only=True)
class RopePendulum(Rope):
    """A container that swings on ropes, and is released at t = 0."""

    hoist: RopePendulumLoad
    model: Literal["rope", "rope-pendulum"] = "rope-pendulum"

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Sway, then lift, of the container."""
        return (*SWAYS, LIFT)

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Channels of the rope, and the sway."""
        return (*super().channel_names, *SWAY)

    def rolling(self, ratios: Mapping[str, float]) -> np.ndarray:
        """Motion of its coordinates per motor angle."""
        return np.array([0.0, 0.0, self.rise(ratios)])

    def translation(self) -> np.ndarray:
        """Sway along x and y, lift along z."""
        return np.eye(3)

    @property
    def along(self) -> np.ndarray:
        """Unit vector (3,) of the ropes at t = 0, from the container."""
        along = np.array([math.tan(self.hoist.sway_x), math.tan(self.hoist.sway_y), 1.0])
        return along / np.linalg.norm(along)

    def holding_force(self, lay: Coordinates) -> np.ndarray:
        """Force (n,) that holds the container at its angle until t = 0, perpendicular to the ropes."""
        if not (self.hoist.sway_x or self.hoist.sway_y):
            return np.zeros(lay.size)
        along = self.along * [1.0, 1.0, -1.0]
        force = self.hoist.container_mass * lay.gravity * (-along[2] * along + [0.0, 0.0, 1.0])
        return force @ np.array([lay.own_row(name) for name in self.coordinates])

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """Ropes of every drum; the first guess is the force of the held container on drums at rest."""
        weight = self.weight_per_drum(lay.gravity)
        stiffness, swing = self.stiffness_times_length / self.hoist.rope_length, weight / self.hoist.rope_length
        along = self.along
        tension = self.hoist.container_mass * lay.gravity * along[2] / len(self.drums)
        distance = self.hoist.rope_length * (1 + tension / self.stiffness_times_length)
        stretch, x, y = distance * along[2] - self.hoist.rope_length, distance * along[0], distance * along[1]
        sway = np.array([lay.own_row(name) for name in SWAYS])
        for i, place in enumerate(self.drums):
            yield Element(
                kind="pendulum",
                name=f"rope:{i}",
                part=PART,
                words=WORDS,
                rule=pendulum_rule,
                values=(
                    self.stiffness_times_length, self.hoist.rope_length, self.travel(lay.ratios[self.shaft]), self.loss
                ),
                rows=np.vstack([self.stretch_row(lay, place), sway]),
                row_names=("stretch", "x", "y"),
                scale=(weight, weight, weight),
                stiffness=(stiffness, swing, swing),
                damping=(self.loss * math.sqrt(stiffness), 0.0, 0.0),
                guess=(
                    stiffness * stretch - tension * along[2], swing * x - tension * along[0],
                    swing * y - tension * along[1],
                ),
                signals=(Signal(ROPE_FORCE, "N", force=(1.0, 0.0, 0.0)),),
            )  # fmt: skip

    def readings(self, lay: Coordinates) -> dict[str, Reading]:
        """Channels of the rope, and the sway."""
        sways = {name: Reading("m", displacement=lay.own_row(own)) for name, own in zip(SWAY, SWAYS, strict=True)}
        return super().readings(lay) | sways
