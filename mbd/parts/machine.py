"""Machine: what there is, in SI, before any matrix is formed.

Shafts lie along y; the shaft of the first motor is the input. The lifting angle of every shaft is positive and follows
from the motor angle by the ratios of meshes and shaft couplings: the rolling pattern of the train. Motors on further
shafts turn at the ratio of their shaft.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from mbd.elements.component import Component, Link
from mbd.parts.bearings import BearingSpec
from mbd.parts.checks import MachineError, finite, known, unique
from mbd.parts.couplings import ShaftCoupling, check_coaxial
from mbd.parts.drive import CouplingSpec, Drive, SpeedProfile
from mbd.parts.gear_mesh import MeshSpec, mesh_rows
from mbd.parts.load import Excitation, Load
from mbd.parts.losses import Brake, Losses, NoLosses
from mbd.parts.shafts import ShaftSpec
from mbd.parts.train import shaft_ratios

STANDARD_GRAVITY = 9.80665


@dataclass(frozen=True, eq=False, kw_only=True)
class Machine:
    """Shafts in bearings, geared by meshes, driven by motors, loaded at the drums.

    ``gravity`` (m/s2, along -z) acts on shafts, disks and container; the casing's own weight only shifts its rest
    position and is left out. ``gyroscopic`` adds the gyroscopic moments of shafts and disks.
    """

    shafts: tuple[ShaftSpec, ...]
    bearings: tuple[BearingSpec, ...]
    meshes: tuple[MeshSpec, ...]
    couplings: tuple[CouplingSpec, ...]
    profile: SpeedProfile
    load: Load
    shaft_couplings: tuple[ShaftCoupling, ...] = ()
    forces: tuple[Excitation, ...] = ()
    gravity: float = STANDARD_GRAVITY
    losses: Losses = NoLosses()
    brake: Brake | None = None
    gyroscopic: bool = False

    def __post_init__(self) -> None:
        shafts = [s.name for s in self.shafts]
        unique("shafts", shafts)
        unique("bearings", [b.name for b in self.bearings])
        unique("meshes", [m.name for m in self.meshes])
        unique("couplings", [c.name for c in self.couplings] + [j.name for j in self.shaft_couplings])
        finite("gravity", self.gravity)
        if not self.couplings:
            raise MachineError("machine: no motor coupling; at least one must hold the input shaft.")
        unique("forces", [force.name for force in self.forces])
        for component in self.components:
            for what, shaft, y in component.places:
                known(f"{what} shaft", shaft, shafts)
                self.shaft(shaft).check_station(what, y)
        for coupling in self.shaft_couplings:
            check_coaxial(coupling, *(self.shaft(name) for name in coupling.shafts))
        for mesh in self.meshes:
            mesh_rows(mesh, self.shaft(mesh.driving), self.shaft(mesh.driven))
        self.ratios()

    def shaft(self, name: str) -> ShaftSpec:
        """The shaft called ``name``."""
        return next(s for s in self.shafts if s.name == name)

    def mesh(self, name: str) -> MeshSpec:
        """The mesh called ``name``."""
        return next(m for m in self.meshes if m.name == name)

    @property
    def components(self) -> tuple[Component, ...]:
        """Everything in the machine, in the order of channels and of parts."""
        brake = () if self.brake is None else (self.brake,)
        return (
            Drive(couplings=self.couplings),
            *self.shafts,
            *self.meshes,
            *self.bearings,
            self.load,
            *self.shaft_couplings,
            *self.forces,
            *brake,
        )

    def stations(self, name: str) -> tuple[float, ...]:
        """Positions y on the shaft ``name`` that need a node."""
        places = (place for component in self.components for place in component.places)
        return tuple(place.y for place in places if place.shaft == name)

    @property
    def links(self) -> tuple[Link, ...]:
        """What makes shafts turn together."""
        return tuple(link for component in self.components for link in component.links)

    def ratios(self) -> dict[str, float]:
        """Lifting angle of every shaft per motor angle.

        Raises
        ------
        MachineError : a shaft that no motor turns, or a closed loop whose ratios do not agree
        """
        return shaft_ratios([s.name for s in self.shafts], self.links, self.couplings[0].shaft)

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
            load=self.load.turned(angle, ratios[self.load.shaft]),
            shaft_couplings=tuple(coupling.turned(turns) for coupling in self.shaft_couplings),
            forces=tuple(force.turned(turns) for force in self.forces),
        )

    def check_run(self, end: float) -> None:
        """Raise MachineError if the load does not allow the motion up to ``end`` (s)."""
        self.load.check_run(self.profile, self.ratios()[self.load.shaft], end)
