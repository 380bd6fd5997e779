"""Losses of meshes and bearings: models `none`, `efficiency`, `coulomb`; and the holding brake.

The forces are computed in `mbd.forces`: `efficiency`, `sliding`, `drag`. All are internal torques. They change their
sign smoothly with the speed omega of the element, as tanh(omega/omega_0); omega_0 is a share of the highest speed in
the run (`mbd.parts.linear_reference`). At rest there is neither loss nor static friction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from fem.options import option
from mbd.elements.component import Component, Place
from mbd.parts.part_checks import Options


class Losses(Options):
    """Interface of the loss models; an element of `mbd.forces` is omitted if its parameter here is 0 or None."""

    mesh_efficiency: float | None = None
    tooth_friction: float = 0.0
    bearing_friction: float = 0.0


@dataclass(frozen=True, kw_only=True)
class NoLosses(Losses):
    """Meshes and bearings without friction."""

    model: Literal["none"] = "none"


@dataclass(frozen=True, kw_only=True)
class Efficiency(Losses):
    """Every mesh transmits the given share of its input power."""

    model: Literal["efficiency"] = "efficiency"
    mesh_efficiency: float = option(0.99, gt=0.5, le=1, text="output power divided by input power of every mesh")


@dataclass(frozen=True, kw_only=True)
class Coulomb(Losses):
    """Sliding friction of the teeth, which reverses at the pitch point, and drag torque of the bearings."""

    model: Literal["coulomb"] = "coulomb"
    tooth_friction: float = option(0.05, ge=0, le=0.5, text="coefficient of friction of a tooth pair")
    bearing_friction: float = option(
        0.0015, ge=0, le=0.1, text="coefficient of friction of the bearings, at half the shaft diameter"
    )


@dataclass(frozen=True, kw_only=True)
class Brake(Component):
    """A holding brake of the given torque (N m) at ``y`` of ``shaft``: closed while the motors stand."""

    shaft: str
    y: float
    torque: float

    @property
    def places(self) -> tuple[Place, ...]:
        """Place of the brake on its shaft."""
        return (Place("brake", self.shaft, self.y),)
