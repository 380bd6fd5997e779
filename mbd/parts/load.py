"""External loads of a machine: the load on its drums, and further forces.

Every kind is a class with the methods below, in a separate file of `mbd.forces`; `StaticTorque` has no element, it
only adds to the constant force. The rest of `mbd` depends on no particular load.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np

from fem.options import check_options
from mbd.elements.component import Component, Place
from mbd.elements.coordinates import Coordinates
from mbd.parts.checks import MachineError
from mbd.parts.speed_drive import SpeedProfile

ROPE_FORCE = "rope:force"  # N, of all falls; for a swinging container the vertical component
CONTAINER = ("container:lift", "container:acceleration")  # m, from the position at t = 0; m/s2
OUTSIDE_FORCE, GROUND_ACCELERATION = "outside_force", "ground_acceleration"  # N, m/s2; after the excitation's name
SWAY = ("container:sway_x", "container:sway_y")  # m


@dataclass(frozen=True, kw_only=True)
class Load(Component, ABC):
    """Load that hangs from the drums at the positions ``drums`` (m) of ``shaft``."""

    shaft: str
    drums: tuple[float, ...]

    @property
    def places(self) -> tuple[Place, ...]:
        """Places of the drums."""
        return tuple(Place("drum", self.shaft, y) for y in self.drums)

    @property
    @abstractmethod
    def idle(self) -> bool:
        """Whether the train has no load at t = 0."""

    @abstractmethod
    def torque_on_shaft(self, gravity: float) -> float:
        """Torque (N m, lowering positive) on its shaft at rest."""

    def largest_torques(self, gravity: float) -> dict[str, float]:
        """Torque of the weight."""
        return {self.shaft: -self.torque_on_shaft(gravity)}

    def starting_torques(self, gravity: float, speeds: Mapping[str, float]) -> dict[str, float]:
        """Torque of the weight, unless it rests on the ground."""
        return {} if self.idle else self.largest_torques(gravity)

    def turned(self, angle: float, ratio: float) -> Load:
        """The load after the motors have rolled by ``angle`` (rad); MachineError if this is impossible."""
        return self

    def check_turned(self, angle: float, time: float) -> None:
        """Raise MachineError if its shaft cannot have turned by ``angle`` (rad) at a ``time`` (s)."""

    def check_run(self, profile: SpeedProfile, ratio: float, end: float) -> None:
        """Raise MachineError if the load does not allow the motion up to ``end`` (s)."""


@dataclass(frozen=True, kw_only=True)
class StaticTorque(Load):
    """A constant torque (N m, lowering positive) on each drum.

    With a ``direction`` (rad, from +x to +z) the torque comes from a rope that pulls the drum in this direction with
    torque/``drum_radius``.
    """

    torque: float
    direction: float | None = None
    drum_radius: float = 0.0
    model: Literal["static-torque"] = "static-torque"

    @property
    def idle(self) -> bool:
        """Whether there is no torque."""
        return self.torque == 0.0

    def torque_on_shaft(self, gravity: float) -> float:
        """Torque of all drums."""
        return self.torque * len(self.drums)

    def constant_force(self, lay: Coordinates) -> np.ndarray:
        """Torque on the rotation of every drum, and pull across the shaft."""
        force = np.zeros(lay.size)
        for y in self.drums:
            force -= self.torque * lay.angle_row(self.shaft, y)
            if self.direction is not None:
                pull = np.array([*pull_axis(self.direction), 0.0, 0.0, 0.0]) * self.torque / self.drum_radius
                force += lay.node_row(self.shaft, y, pull)
        return force


def pull_axis(direction: float | None) -> tuple[float, float, float]:
    """Unit vector (x, y, z) of the ropes' pull at the drum; zero if it is balanced there."""
    return (0.0, 0.0, 0.0) if direction is None else (math.cos(direction), 0.0, math.sin(direction))


@dataclass(frozen=True, eq=False, kw_only=True)
class Excitation(Component):
    """Named external force in addition to the load: nonlinear `elements`, linear `parts`, or a constant force."""

    name: str

    def __post_init__(self) -> None:
        check_options(self, MachineError, self.name)

    @property
    def casing_rows(self) -> tuple[str, ...]:
        """Rows of the casing on which it acts, e.g. ``sensor_1:uz``."""
        return ()

    def turned(self, turns: Mapping[str, float]) -> Self:
        """The force after the shafts by name have turned by ``turns`` (rad, in their lifting sense); its times are
        unchanged."""
        return self


@dataclass(frozen=True, eq=False, kw_only=True)
class OutsideForce(Excitation):
    """A force at ``y`` (m) of ``shaft``."""

    shaft: str
    y: float

    @property
    def highest_speed(self) -> float:
        """Highest speed (rad/s) to which it drives its shaft, 0 if it does not drive."""
        return 0.0

    @property
    def places(self) -> tuple[Place, ...]:
        """Place of the force on its shaft."""
        return (Place(self.name, self.shaft, self.y),)


@dataclass(frozen=True, eq=False, kw_only=True)
class TurningForce(OutsideForce):
    """A force that turns with its shaft; its angle holds when the shaft is at the angle -``rolled`` (rad, in its
    lifting sense)."""

    rolled: float = 0.0

    def turned(self, turns: Mapping[str, float]) -> Self:
        """The force after its shaft has turned."""
        return replace(self, rolled=self.rolled + turns[self.shaft])

    def direction(self, lay: Coordinates, angle: float) -> tuple[float, float, float]:
        """The first arguments of `mbd.excitations.turned_direction.turned_direction` for an angle alpha (rad)."""
        sense = float(lay.sense(self.shaft))
        return angle - sense * self.rolled, sense, lay.ratios[self.shaft]
