"""Machine: all parts of a drivetrain in SI, before matrices are formed.

Shafts lie along y; the shaft of the first drive is the input. The angle of every shaft is positive in the sense that
this drive turns it, and follows from the drive's angle by the ratios of meshes and shaft couplings: the rolling pattern
of the train. Motors on further shafts turn at the ratio of their shaft.

Where motors prescribe the speed, the train rolls as they do. Without them it is free: its rolling follows from the
torques on it, see `mbd.system.rolling_frame`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from mbd.elements.component import Component, Link
from mbd.parts.bearings import BearingSpec
from mbd.parts.couplings import ShaftCoupling
from mbd.parts.gear_mesh import GearedShafts, MeshSpec
from mbd.parts.load import Excitation, Load, OutsideForce
from mbd.parts.losses import Brake, Losses, NoLosses
from mbd.parts.shafts import ShaftSpec
from mbd.parts.speed_drive import Drive, MotorCoupling, SpeedProfile
from mbd.parts.train import shaft_ratios

STANDARD_GRAVITY = 9.80665


@dataclass(frozen=True, eq=False, kw_only=True)
class Train:
    """Everything in a machine, its meshes with or without their laws.

    Without ``couplings`` to motors of prescribed speed, torques among ``forces`` drive the shaft ``input_shaft``, and
    ``profile`` gives only its speed at the start. ``gravity`` (m/s2, along -z) acts on shafts, disks, container and
    casing. ``gyroscopic`` adds the gyroscopic moments of shafts and disks.
    """

    shafts: tuple[ShaftSpec, ...]
    bearings: tuple[BearingSpec, ...]
    couplings: tuple[MotorCoupling, ...] = ()
    input_shaft: str = ""  # left out: that of the first coupling
    profile: SpeedProfile
    load: Load | None = None  # load of the drums
    shaft_couplings: tuple[ShaftCoupling, ...] = ()
    forces: tuple[Excitation, ...] = ()
    gravity: float = STANDARD_GRAVITY
    losses: Losses = NoLosses()
    brake: Brake | None = None
    gyroscopic: bool = False
    probes: tuple[Component, ...] = ()  # channels without a force
    meshes: tuple[GearedShafts, ...]

    @property
    def components(self) -> tuple[Component, ...]:
        """Everything in the machine, in the order of channels and of parts."""
        brake = () if self.brake is None else (self.brake,)
        return (
            *((Drive(couplings=self.couplings),) if self.couplings else ()),
            *self.shafts,
            *self.meshes,
            *self.bearings,
            *(() if self.load is None else (self.load,)),
            *self.shaft_couplings,
            *self.forces,
            *brake,
            *self.probes,
        )

    def geared(self, meshes: tuple[MeshSpec, ...]) -> Machine:
        """The machine with its meshes. MachineError names what does not fit."""
        return Machine(**{item.name: getattr(self, item.name) for item in fields(Train)} | {"meshes": meshes})


@dataclass(frozen=True, eq=False, kw_only=True)
class Machine(Train):
    """Shafts in bearings, geared by meshes, driven and loaded."""

    meshes: tuple[MeshSpec, ...]

    def __post_init__(self) -> None:
        for component in self.components:
            for what, shaft, y in component.places:
                self.shaft(shaft).check_station(what, y)

    def shaft(self, name: str) -> ShaftSpec:
        """The shaft called ``name``."""
        return next(s for s in self.shafts if s.name == name)

    @property
    def driven(self) -> str:
        """Name of the shaft of the first drive."""
        return self.input_shaft or self.couplings[0].shaft

    @property
    def free(self) -> bool:
        """Whether torques alone drive the train, so that its rolling is part of the answer."""
        return not self.couplings

    def stations(self, name: str) -> tuple[float, ...]:
        """Positions y on the shaft ``name`` that need a node."""
        places = (place for component in self.components for place in component.places)
        return tuple(place.y for place in places if place.shaft == name)

    @property
    def links(self) -> tuple[Link, ...]:
        """Connections of shafts by meshes and couplings."""
        return tuple(link for component in self.components for link in component.links)

    def ratios(self) -> dict[str, float]:
        """Angle of every shaft per angle of the first drive.

        Raises
        ------
        MachineError : a shaft that no motor turns, or a closed loop whose ratios do not agree
        """
        return shaft_ratios(self.links, self.driven)

    def turned(self, angle: float) -> Machine:
        """The machine after its motors have rolled by ``angle`` (rad): mesh cycles, rope length and what turns with the
        shafts move, nothing else.

        Raises
        ------
        MachineError : the drums have then wound more rope than there is
        """
        ratios = self.ratios()
        meshes = tuple(mesh.turned(ratios[mesh.driving] * angle) for mesh in self.meshes)
        turns = {name: ratio * angle for name, ratio in ratios.items()}
        return replace(
            self,
            meshes=meshes,
            load=None if self.load is None else self.load.turned(angle, ratios[self.load.shaft]),
            shaft_couplings=tuple(coupling.turned(turns) for coupling in self.shaft_couplings),
            forces=tuple(force.turned(turns) for force in self.forces),
        )

    @property
    def starting_speed(self) -> float:
        """Speed of the first drive at t = 0, rad/s."""
        return float(self.profile.speed(np.zeros(1))[0])

    @property
    def highest_speed(self) -> float:
        """Highest |speed| of the first drive that is known before the run, rad/s."""
        ratios = self.ratios()
        own = [
            abs(force.highest_speed) / ratios[force.shaft] for force in self.forces if isinstance(force, OutsideForce)
        ]
        return max([self.profile.highest, *own])

    def largest_torques(self) -> dict[str, float]:
        """Torque (N m) of greatest magnitude from outside by shaft, without what motors of prescribed speed give."""
        return _summed(component.largest_torques(self.gravity) for component in self.components)

    def starting_torques(self) -> dict[str, float]:
        """The same at t = 0."""
        speeds = {name: ratio * self.starting_speed for name, ratio in self.ratios().items()}
        return _summed(component.starting_torques(self.gravity, speeds) for component in self.components)

    def check_run(self, end: float) -> None:
        """Raise MachineError if the load does not allow the motion up to ``end`` (s)."""
        if self.load is not None and not self.free:
            self.load.check_run(self.profile, self.ratios()[self.load.shaft], end)


def _summed(torques: Iterable[Mapping[str, float]]) -> dict[str, float]:
    total: dict[str, float] = {}
    for found in torques:
        for shaft, torque in found.items():
            total[shaft] = total.get(shaft, 0.0) + torque
    return total
