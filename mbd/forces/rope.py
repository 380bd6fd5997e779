"""Container on vertical ropes: a load that hangs from the drums by elastic falls.

The container (mass m) hangs from n falls that lead to the drums; a drum angle phi lifts it by phi R/reeving. A drum
carries n/drums falls of the stiffness k = (n/drums) EA/L with the length L = L_0 - phi R/reeving in rigid rolling,
and the force max(0, k s + c s') while the stretch s = phi R/reeving - x > 0; else the rope is slack.
c = 2 zeta sqrt(k m/drums). U = k s^2/2 depends on the motor angle by L.

With a direction d (unit vector across the shaft) the ropes also pull the drum: it moves by u and s = (phi R - d . u)/
reeving - x, so that F/reeving acts along d. Without a direction the pull is balanced at the drum.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from fem.options import option
from mbd.elements.channel_reading import Reading
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import BY_ANGLE, ENERGY, Element, Signal, rule
from mbd.elements.linear_part import Matrices, Part
from mbd.elements.mode_words import ModeWords
from mbd.forces.container_ground import ground
from mbd.forces.hanging_loads import HangingLoad
from mbd.parts.load import CONTAINER, ROPE_FORCE, Load, pull_axis
from mbd.parts.part_checks import MachineError
from mbd.parts.speed_drive import SpeedProfile

LIFT = "container:lift"
PART = "rope"
WORDS = ModeWords("rope", "rope", always=True, has_mass=True, moving="rope bounce")
STIFFNESS_TIMES_LENGTH, LENGTH, TRAVEL, LOSS = range(4)  # loss: 2 zeta sqrt(mass per rope)


@rule(__file__)
def rope_rule(values, motion, answer):
    """Force on the stretch (m) of the ropes of one drum."""
    stretch = motion.u[0]
    if stretch <= 0.0:
        return
    length = values[LENGTH] - values[TRAVEL] * motion.angle
    k = values[STIFFNESS_TIMES_LENGTH] / length
    elastic, c = k * stretch, values[LOSS] * math.sqrt(k)
    answer.elastic[0], answer.stiffness[0, 0] = elastic, k
    answer.log[ENERGY] = 0.5 * elastic * stretch
    answer.log[BY_ANGLE] = answer.log[ENERGY] * values[TRAVEL] / length
    if elastic + c * motion.v[0] > 0.0:
        answer.lost[0], answer.lost_by_v[0, 0] = c * motion.v[0], c
    else:
        answer.lost[0], answer.lost_by_u[0, 0] = -elastic, -k


@dataclass(frozen=True, kw_only=True)
class RopeLoad(HangingLoad):
    """A hanging mass on an elastic rope: stiffness of the current length, tension only."""

    model: Literal["rope"] = "rope"
    rope_diameter: float = option(0.01, unit="mm", gt=0, text="nominal diameter")
    rope_modulus: float = option(1e11, unit="GPa", gt=0, text="elastic modulus on the metallic area")
    rope_fill_factor: float = option(0.455, gt=0, le=1, text="metallic area divided by the area of the circle")
    rope_falls: int = option(8, ge=1, text="number of falls that carry the mass")
    rope_length: float = option(5.0, unit="m", gt=0, text="free length at t = 0")
    rope_damping_ratio: float = option(
        0.02, ge=0, lt=1, text="damping ratio of the vertical vibration at the initial length"
    )
    ground_level: float | None = option(
        None,
        unit="m",
        text="height of the ground above the place at which the mass would hang from a rigid "
        "rope at t = 0. If it is positive, the mass rests on the ground and the rope is "
        "slack by this amount; without it: no ground; not for rope-pendulum",
    )
    ground_stiffness: float = option(1e7, unit="N/um", gt=0, text="stiffness of the ground")
    ground_damping_ratio: float = option(0.1, ge=0, lt=10, text="damping ratio of the mass on the ground")

    @property
    def axial_stiffness(self) -> float:
        """Axial stiffness EA of one fall (N); A is the metallic area."""
        return self.rope_modulus * (self.rope_fill_factor * math.pi / 4 * self.rope_diameter**2)

    def rope_frequency(self) -> float | None:
        """At the free length."""
        return self._frequency(self.rope_length)

    def rope_frequency_at(self, time: float, profile: SpeedProfile, ratio: float) -> float | None:
        """At the length that is left."""
        return self._frequency(self.rope_length_at(time, profile, ratio))

    def _frequency(self, length: float) -> float | None:
        """Of the mass on EA/length."""
        if self.container_mass == 0:
            return None
        stiffness = self.rope_falls * self.axial_stiffness / length
        return math.sqrt(stiffness / self.container_mass) / (2 * math.pi)

    def rope_length_at(self, time: float, profile: SpeedProfile, ratio: float) -> float:
        """Free length (m) at a time: that at the start less what the drums have wound. For the parameters see
        `rope_frequency_at`."""
        angle = float(profile.angle(np.array([time]))[0]) * ratio
        return self.rope_length - angle * self.drum_radius / self.reeving_ratio

    def load(self, shaft: str, drums: tuple[float, ...]) -> Load:
        """The ropes with the container; without container a torque of zero."""
        if self.container_mass == 0:
            return self.weight(shaft, drums)
        return self.on_drums(shaft, drums)

    def on_drums(self, shaft: str, drums: tuple[float, ...]) -> Rope:
        """The ropes with the container; arguments as for `load`."""
        return Rope(shaft=shaft, drums=drums, hoist=self)


@dataclass(frozen=True, kw_only=True)
class Rope(Load):
    """A container on ropes."""

    hoist: RopeLoad
    follow_length: bool = True  # False: keep the stiffness of the initial length
    model: Literal["rope", "rope-pendulum"] = "rope"

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Lift of the container."""
        return (LIFT,)

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Rope force, lift and acceleration of the container."""
        return (ROPE_FORCE, *CONTAINER)

    @property
    def travel_per_radian(self) -> float:
        """Lift of the container per radian of the drum (m)."""
        return self.hoist.drum_radius / self.hoist.reeving_ratio

    @property
    def stiffness_times_length(self) -> float:
        """EA of all falls of one drum (N): k = this / L."""
        return self.hoist.rope_falls * self.hoist.axial_stiffness / len(self.drums)

    @property
    def loss(self) -> float:
        """2 zeta sqrt(mass per drum): the damping of the ropes of a drum is this times the root of their stiffness."""
        return 2 * self.hoist.rope_damping_ratio * math.sqrt(self.hoist.container_mass / len(self.drums))

    @property
    def idle(self) -> bool:
        """Whether the container rests on the ground at t = 0 with slack ropes."""
        return self.hoist.ground_level is not None and self.hoist.ground_level > 0.0

    def torque_on_shaft(self, gravity: float) -> float:
        """Torque (N m, lowering positive) of the hanging weight."""
        return self.hoist.container_mass * gravity * self.travel_per_radian

    def rise(self, ratios: Mapping[str, float]) -> float:
        """Lift of the container (m) per motor angle."""
        return self.travel_per_radian * ratios[self.shaft]

    def rolling(self, ratios: Mapping[str, float]) -> np.ndarray:
        """Motion of its coordinates per motor angle."""
        return np.array([self.rise(ratios)])

    def translation(self) -> np.ndarray:
        """Lift of the container along z."""
        return np.array([[0.0, 0.0, 1.0]])

    def parts(self, lay: Coordinates) -> Iterator[Part]:
        """The container."""
        n = len(self.coordinates)
        yield Part(
            name="load",
            modes_of=PART,
            words=WORDS,
            matrices=Matrices(mass=self.hoist.container_mass * np.eye(n)),
            index=np.array([int(np.argmax(lay.own_row(name))) for name in self.coordinates]),
            shape=np.eye(n),
        )

    def constant_force(self, lay: Coordinates) -> np.ndarray:
        """Weight of the container on its lift."""
        return -lay.gravity * self.hoist.container_mass * lay.own_row(LIFT)

    def stretch_row(self, lay: Coordinates, y: float) -> np.ndarray:
        """Row of the stretch of the ropes of the drum at ``y``."""
        row = self.travel_per_radian * lay.angle_row(self.shaft, y)
        pull = np.array([*pull_axis(self.hoist.rope_direction), 0.0, 0.0, 0.0])
        row -= lay.node_row(self.shaft, y, pull) / self.hoist.reeving_ratio
        return row - lay.own_row(LIFT)

    def weight_per_drum(self, gravity: float) -> float:
        """Weight (N) on the ropes of a drum, at least 1 N in total: the scale of their force."""
        return max(self.hoist.container_mass * gravity, 1.0) / len(self.drums)

    def travel(self, ratio: float) -> float:
        """Shortening (m) of the ropes per motor angle; 0 if their stiffness does not follow it."""
        return self.travel_per_radian * ratio if self.follow_length else 0.0

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """The ropes of every drum, and the ground."""
        stiffness = self.stiffness_times_length / self.hoist.rope_length
        travel = self.travel(lay.ratios[self.shaft])
        for i, y in enumerate(self.drums):
            yield Element(
                kind="rope",
                name=f"rope:{i}",
                part=PART,
                words=WORDS,
                rule=rope_rule,
                values=(self.stiffness_times_length, self.hoist.rope_length, travel, self.loss),
                rows=self.stretch_row(lay, y)[None],
                row_names=("stretch",),
                scale=(self.weight_per_drum(lay.gravity),),
                stiffness=(stiffness,),
                damping=(self.loss * math.sqrt(stiffness),),
                opens=True,
                signals=(Signal(ROPE_FORCE, "N", force=(1.0,)),),
                contact_lost="rope:slack_events",
            )
        hoist = self.hoist
        if hoist.ground_level is not None:
            stiffness = hoist.ground_stiffness
            damping = 2 * hoist.ground_damping_ratio * (stiffness * hoist.container_mass) ** 0.5
            values = stiffness, damping, hoist.ground_level, self.rise(lay.ratios)
            yield ground(lay, LIFT, hoist.container_mass, values)

    def readings(self, lay: Coordinates) -> dict[str, Reading]:
        """Channels of the container's motion."""
        rise, lift = self.rise(lay.ratios), lay.own_row(LIFT)
        return {
            CONTAINER[0]: Reading("m", displacement=lift, rigid=(rise, 0.0, 0.0)),
            CONTAINER[1]: Reading("m/s2", acceleration=lift, rigid=(0.0, 0.0, rise)),
        }

    def turned(self, angle: float, ratio: float) -> Rope:
        """The rope after the motors have rolled by ``angle`` (rad)."""
        if not self.follow_length:
            return self
        wound = self.travel_per_radian * ratio * angle
        if wound >= self.hoist.rope_length:
            raise MachineError(
                f"motor angle {angle:.6g} rad: the drums have then wound {wound:.4g} m of "
                f"{self.hoist.rope_length:.4g} m of rope. Stay below, or start with a longer rope."
            )
        return replace(self, hoist=replace(self.hoist, rope_length=self.hoist.rope_length - wound))

    def check_turned(self, angle: float, time: float) -> None:
        """Raise MachineError if the drums have wound more than the length of the rope by then."""
        if self.follow_length and self.travel_per_radian * angle >= self.hoist.rope_length:
            raise MachineError(
                f"rope: its {self.hoist.rope_length:.4g} m are wound up at t = {time:.4g} s. Raise load.rope_length_m, "
                "lower the torque of the drive, or end the run before."
            )

    def check_run(self, profile: SpeedProfile, ratio: float, end: float) -> None:
        """Raise MachineError if the drums would wind more than the length of the rope before ``end`` (s)."""
        if not self.follow_length:
            return
        corners = profile.times[(profile.times > 0.0) & (profile.times < end)]
        times = np.concatenate([np.linspace(0.0, end, 1001), corners])
        wound = self.travel_per_radian * ratio * profile.angle(times)
        if wound.max() >= self.hoist.rope_length:
            when = times[wound >= self.hoist.rope_length].min()
            raise MachineError(
                f"rope: its {self.hoist.rope_length:.4g} m are wound up at t = {when:.4g} s (by {end:.4g} s the drums "
                f"would take {wound.max():.4g} m). Raise load.rope_length_m, or lift less."
            )
