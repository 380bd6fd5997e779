"""What the casing models with finite elements share: mesh, modes with their check-up, body."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fem.casing.geometry.dimensions import Sensor
from fem.casing.geometry.housing import Housing
from fem.casing.meshing.mesh import CasingMesh
from fem.casing.meshing.sizes import Sizes
from fem.casing.meshing.source import mesh_geometry
from fem.casing.parts.bolted_joint import BoltedJoint
from fem.casing.parts.regions import Region
from fem.casing.reduced.body import ReducedBody
from fem.casing.reduced.checkup import CheckUp
from fem.casing.reduced.damping import DampingRatio
from fem.casing.reduced.grounded import Attachment, ForcedPoint, Ground, GroundedCasing, ground_casing
from fem.casing.reduced.modes import CasingModes, Mounts, reduced_body
from fem.elements.materials import Material
from fem.numerics.linear_solver import Solver


@dataclass(frozen=True, kw_only=True)
class ElasticCasing(ABC):
    """What the casing models with finite elements share: they go through steps that can be stored one by one.

    `limit` (Hz): modes up to it are kept, None where a model has none.
    """

    model: str

    element_size: float = 0.022  # m
    ground: Ground = "fixed"
    attachment: Attachment = "mean"
    interfaces: Mapping[str, Sequence[str]] | None = None  # bearing -> axes that carry loads; all by default
    forced: tuple[ForcedPoint, ...] = ()  # surface points that bear outside forces
    mounts: Mounts | None = None  # stiffness of the feet, if the ground is "springs"
    damping: DampingRatio = 0.01
    regions: tuple[Region, ...] = ()  # parts whose strain energy is told from that of the rest
    joint: BoltedJoint | None = None  # bolts between two halves; None: one body
    solver: Solver = "auto"

    @property
    def limit(self) -> float | None:
        """Frequency (Hz) up to which modes are kept."""
        return None

    def mesh(self, housing: Housing) -> CasingMesh:
        """First stage: geometry to ten-node tetrahedra."""
        return mesh_geometry(housing, Sizes(element=self.element_size))

    def casing(self, mesh: CasingMesh, material: Material) -> GroundedCasing:
        """The meshed casing in its ground, factorised."""
        return ground_casing(
            mesh,
            material,
            interfaces=self.interfaces,
            forced=self.forced,
            ground=self.ground,
            attachment=self.attachment,
            regions=self.regions,
            joint=self.joint,
            solver=self.solver,
        )

    @abstractmethod
    def modes(self, mesh: CasingMesh, material: Material) -> tuple[CasingModes, CheckUp]:
        """Second stage: factorise and reduce; the check-up tells whether the result can be trusted."""

    def body(self, modes: CasingModes, sensors: Sequence[Sensor] = ()) -> ReducedBody:
        """Last stage: mounts, damping and the rows of the sensors asked."""
        return reduced_body(modes, sensors=sensors, damping=self.damping, mounts=self.mounts, limit=self.limit)

    def reduce(self, housing: Housing, material: Material) -> ReducedBody:
        """All stages."""
        return self.body(self.modes(self.mesh(housing), material)[0], housing.sensors)
