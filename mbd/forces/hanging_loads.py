"""Loads of a container on the ropes of drums, by name (LOADS), each a frozen class of options that makes a load."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Literal

from fem.named_classes import named_class
from fem.options import option
from mbd.parts.load import Load, StaticTorque
from mbd.parts.machine import STANDARD_GRAVITY
from mbd.parts.part_checks import MachineError, Options
from mbd.parts.speed_drive import SpeedProfile

LOADS = {
    "static-torque": ("mbd.forces.hanging_loads", "StaticTorqueLoad"),
    "rope": ("mbd.forces.rope", "RopeLoad"),
    "rope-pendulum": ("mbd.forces.pendulum", "RopePendulumLoad"),
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
    reeving_ratio: float = option(2.0, gt=0, text="rope speed at the drum divided by speed of the mass")
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

    def weight(self, shaft: str, drums: tuple[float, ...]) -> Load:
        """The weight as a constant torque; arguments as for `load`."""
        return StaticTorque(
            shaft=shaft,
            drums=drums,
            torque=self.torque / len(drums),
            direction=self.rope_direction,
            drum_radius=self.drum_radius,
        )

    @abstractmethod
    def load(self, shaft: str, drums: tuple[float, ...]) -> Load:
        """The load on drums at y (m) of a shaft. MachineError if its values do not fit together."""


@dataclass(frozen=True, kw_only=True)
class StaticTorqueLoad(HangingLoad):
    """The weight of a hanging mass, as a constant torque on the drums."""

    model: Literal["static-torque"] = "static-torque"

    def load(self, shaft: str, drums: tuple[float, ...]) -> Load:
        """A constant torque."""
        return self.weight(shaft, drums)
