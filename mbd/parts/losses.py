"""Losses of meshes and bearings: models `none`, `efficiency`, `coulomb`; and the holding brake. All are internal
torques.

The forces stand in `mbd.forces`: `efficiency`, `sliding`, `drag`. All reverse smoothly with the speed omega of the
element, as tanh(omega/omega_0); omega_0 is a share of the highest speed in the run (`mbd.reference.assembly`). At rest
nothing is lost and nothing is held by friction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from mbd.elements.component import Component, Place
from mbd.parts.checks import MachineError, not_negative


class Losses:
    """What every model answers; the elements of `mbd.forces` that these numbers are for are left out where they are 0
    or None."""

    mesh_efficiency: float | None = None
    tooth_friction: float = 0.0
    bearing_friction: float = 0.0


@dataclass(frozen=True, kw_only=True)
class NoLosses(Losses):
    """Nothing is lost in meshes and bearings."""

    model: Literal["none"] = "none"


@dataclass(frozen=True, kw_only=True)
class Efficiency(Losses):
    """Every mesh passes on the share ``mesh_efficiency`` of the power that enters it."""

    mesh_efficiency: float
    model: Literal["efficiency"] = "efficiency"

    def __post_init__(self) -> None:
        if not 0.5 < self.mesh_efficiency <= 1.0:
            raise MachineError(f"losses: mesh_efficiency {self.mesh_efficiency!r} must be above 0.5 and at most 1.")


@dataclass(frozen=True, kw_only=True)
class Coulomb(Losses):
    """Sliding friction of the teeth and drag of the bearings, as shares of the normal loads."""

    tooth_friction: float
    bearing_friction: float = 0.0
    model: Literal["coulomb"] = "coulomb"

    def __post_init__(self) -> None:
        not_negative("losses tooth_friction", self.tooth_friction)
        not_negative("losses bearing_friction", self.bearing_friction)
        if max(self.tooth_friction, self.bearing_friction) > 1.0:
            raise MachineError("losses: friction above 1 is no sliding friction of steel.")


@dataclass(frozen=True, kw_only=True)
class Brake(Component):
    """A holding brake of the given torque (N m) at ``y`` of ``shaft``: closed while the motors stand."""

    shaft: str
    y: float
    torque: float

    def __post_init__(self) -> None:
        not_negative("brake torque", self.torque)

    @property
    def places(self) -> tuple[Place, ...]:
        """Where it sits."""
        return (Place("brake", self.shaft, self.y),)
