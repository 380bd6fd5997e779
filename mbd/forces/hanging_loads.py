"""Loads of a container on the ropes of drums, by name (LOADS), each a frozen class of options that makes a load."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fem.named_classes import named_class
from fem.options import option
from mbd.parts.checks import MachineError, Options
from mbd.parts.load import Load, StaticTorque
from mbd.parts.machine import STANDARD_GRAVITY
from mbd.parts.speed_drive import SpeedProfile

LOADS = {
    "static-torque": ("mbd.forces.hanging_loads", "StaticTorqueLoad"),
    "rope": ("mbd.forces.hanging_loads", "RopeLoad"),
    "rope-pendulum": ("mbd.forces.hanging_loads", "RopePendulumLoad"),
}


def load_model(name: str) -> type[HangingLoad]:
    """The class of that name. MachineError if there is none."""
    return named_class(LOADS, name, "load model", MachineError)


@dataclass(frozen=True, kw_only=True)
class HangingLoad(Options, ABC):
    """A weight on drums."""

    container_mass: float = option(unit="kg", key="container_kg", ge=0, text="hanging mass")
    drum_radius: float = option(unit="mm", gt=0, text="radius to the centre of the rope")
    drum_mass: float = option(unit="kg", gt=0, text="mass of each drum")
    drum_inertia: float = option(unit="kg m2", gt=0, text="moment of inertia of each drum about the shaft")
    reeving_ratio: float = option(2.0, gt=0, text="rope speed at the drum over speed of the hanging mass")
    rope_direction: float | None = option(
        None,
        unit="deg",
        ge=-180,
        le=180,
        text="direction of the rope force on the drums: 0 is +x, 90 is up; without it: the drums load "
        "the shaft by torque only",
    )

    @property
    def torque(self) -> float:
        """Torque of the weight on the shaft of the drums (N m): m g R / reeving ratio."""
        return self.container_mass * STANDARD_GRAVITY * self.drum_radius / self.reeving_ratio

    def rope_frequency(self) -> float | None:
        """Bounce frequency (Hz) of the container on its rope at t = 0, drums held; None without rope or container."""
        return None

    def rope_frequency_at(self, time: float, profile: SpeedProfile, ratio: float) -> float | None:
        """The bounce frequency (Hz) at a time; None without rope or container.

        Parameters
        ----------
        time : s
        profile : speed of the motors
        ratio : speed of the drums divided by that of the motors
        """
        return None

    @abstractmethod
    def load(self, shaft: str, drums: tuple[float, ...]) -> Load:
        """The load on drums at y (m) of a shaft. MachineError if its values do not fit together."""


@dataclass(frozen=True, kw_only=True)
class StaticTorqueLoad(HangingLoad):
    """The weight of a hanging mass, as a constant torque on the drums."""

    model: Literal["static-torque"] = "static-torque"

    def load(self, shaft: str, drums: tuple[float, ...]) -> Load:
        """A constant torque."""
        return _weight(self, shaft, drums)


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
        text="height of the ground above the position of the mass on the unstretched rope "
        "at t = 0. If it is positive, the mass rests on the ground and the rope is "
        "slack by this amount; without it: no ground",
    )
    ground_stiffness: float = option(1e7, unit="N/um", gt=0, text="stiffness of the ground")
    ground_damping_ratio: float = option(0.1, ge=0, lt=10, text="damping ratio of the mass on the ground")

    @property
    def _fall_strength(self) -> float:
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
        stiffness = self.rope_falls * self._fall_strength / length
        return math.sqrt(stiffness / self.container_mass) / (2 * math.pi)

    def rope_length_at(self, time: float, profile: SpeedProfile, ratio: float) -> float:
        """Free length (m) at a time: that at the start less what the drums have wound. For the parameters see
        `rope_frequency_at`."""
        angle = float(profile.angle(np.array([time]))[0]) * ratio
        return self.rope_length - angle * self.drum_radius / self.reeving_ratio

    def load(self, shaft: str, drums: tuple[float, ...]) -> Load:
        """The ropes with the container; without container a torque of zero."""
        from mbd.forces.rope import Rope

        return self._on_ropes(Rope, shaft, drums)

    def _on_ropes(self, kind: Any, shaft: str, drums: tuple[float, ...], **others: Any) -> Load:
        from mbd.forces.container_ground import Ground

        if self.container_mass == 0:
            return _weight(self, shaft, drums)
        ground = None
        if self.ground_level is not None:
            ground = Ground(
                level=self.ground_level, stiffness=self.ground_stiffness, damping_ratio=self.ground_damping_ratio
            )
        return kind(
            shaft=shaft,
            drums=drums,
            container_mass=self.container_mass,
            drum_radius=self.drum_radius,
            falls=self.rope_falls,
            axial_stiffness=self._fall_strength,
            length=self.rope_length,
            reeving=self.reeving_ratio,
            damping_ratio=self.rope_damping_ratio,
            direction=self.rope_direction,
            ground=ground,
            **others,
        )


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

    def load(self, shaft: str, drums: tuple[float, ...]) -> Load:
        """The ropes with the swinging container."""
        from mbd.forces.pendulum import RopePendulum

        return self._on_ropes(RopePendulum, shaft, drums, sway=(self.sway_x, self.sway_y))


def _weight(load: HangingLoad, shaft: str, drums: tuple[float, ...]) -> Load:
    return StaticTorque(
        shaft=shaft,
        drums=drums,
        torque=load.torque / len(drums),
        direction=load.rope_direction,
        drum_radius=load.drum_radius,
    )
