"""Machine: what there is, in SI, before any matrix is formed.

Shafts lie along y; the shaft of the first motor is the input. The lifting angle of every shaft is positive and follows
from the motor angle by the ratios of meshes and shaft couplings: the rolling pattern of the train. Motors on further
shafts turn at the ratio of their shaft.
"""

from __future__ import annotations

from dataclasses import dataclass

from mbd.parts.bearings import BearingSpec
from mbd.parts.checks import MachineError, finite, known, unique
from mbd.parts.couplings import ShaftCoupling, check_coaxial
from mbd.parts.drive import CouplingSpec, SpeedProfile
from mbd.parts.gear_mesh import MeshSpec, mesh_rows
from mbd.parts.load import Load, OutsideForce
from mbd.parts.losses import Brake, Losses, NoLosses
from mbd.parts.shafts import ShaftSpec
from mbd.parts.train import Link, shaft_ratios

STANDARD_GRAVITY = 9.80665


@dataclass(frozen=True, eq=False, kw_only=True)
class Machine:
    """Shafts in bearings, coupled by meshes, driven by motors, loaded at the drums.

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
    forces: tuple[OutsideForce, ...] = ()
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
        for bearing in self.bearings:
            known(f"bearing {bearing.name} shaft", bearing.shaft, shafts)
            self.shaft(bearing.shaft).check_station(f"bearing {bearing.name}", bearing.y)
        for coupling in self.couplings:
            known(f"coupling {coupling.name} shaft", coupling.shaft, shafts)
            self.shaft(coupling.shaft).check_station(f"coupling {coupling.name}", coupling.y)
        for joint in self.shaft_couplings:
            for name, y in zip(joint.shafts, joint.y, strict=True):
                known(f"coupling {joint.name} shaft", name, shafts)
                self.shaft(name).check_station(f"coupling {joint.name}", y)
            check_coaxial(joint, *(self.shaft(name) for name in joint.shafts))
        if self.brake is not None:
            known("brake shaft", self.brake.shaft, shafts)
            self.shaft(self.brake.shaft).check_station("brake", self.brake.y)
        unique("forces", [force.name for force in self.forces])
        for force in self.forces:
            known(f"{force.name} shaft", force.shaft, shafts)
            self.shaft(force.shaft).check_station(force.name, force.y)
        known("load shaft", self.load.shaft, shafts)
        for y in self.load.drums:
            self.shaft(self.load.shaft).check_station("drum", y)
        for mesh in self.meshes:
            for name in (mesh.driving, mesh.driven):
                known(f"mesh {mesh.name} shaft", name, shafts)
                self.shaft(name).check_station(f"mesh {mesh.name}", mesh.y)
            mesh_rows(mesh, self.shaft(mesh.driving), self.shaft(mesh.driven))
        self.ratios()

    def shaft(self, name: str) -> ShaftSpec:
        """The shaft called ``name``."""
        return next(s for s in self.shafts if s.name == name)

    def mesh(self, name: str) -> MeshSpec:
        """The mesh called ``name``."""
        return next(m for m in self.meshes if m.name == name)

    def stations(self, name: str) -> tuple[float, ...]:
        """Positions y on the shaft ``name`` that need a node: bearings, meshes, couplings, drums, forces."""
        result = [b.y for b in self.bearings if b.shaft == name]
        result += [m.y for m in self.meshes if name in (m.driving, m.driven)]
        result += [c.y for c in self.couplings if c.shaft == name]
        result += [y for j in self.shaft_couplings for shaft, y in zip(j.shafts, j.y, strict=True) if shaft == name]
        result += [self.brake.y] if self.brake is not None and self.brake.shaft == name else []
        result += list(self.load.drums) if self.load.shaft == name else []
        result += [force.y for force in self.forces if force.shaft == name]
        return tuple(result)

    def ratios(self) -> dict[str, float]:
        """Lifting angle of every shaft per motor angle.

        Raises
        ------
        MachineError : a shaft that no motor turns, or a closed loop whose ratios do not agree
        """
        links = [Link(f"mesh {m.name}", m.driving, m.driven, m.ratio) for m in self.meshes]
        links += [Link(f"coupling {j.name}", *j.shafts, 1.0) for j in self.shaft_couplings]
        return shaft_ratios([s.name for s in self.shafts], links, self.couplings[0].shaft)

    def check_run(self, end: float) -> None:
        """Raise MachineError if the load does not allow the motion up to ``end`` (s)."""
        self.load.check_run(self.profile, self.ratios()[self.load.shaft], end)
