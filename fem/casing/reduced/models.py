"""The rungs of the casing, cheap to dear; each returns a ReducedBody from `reduce`.

none            bearings held by the ground; no casing motion, no sensors
rigid           six coordinates on mount springs; valid below the first elastic mode of the housing
static          Guyan condensation to the bearing points; valid well below the first fixed-interface mode
craig-bampton   every mode to 1.5 times the wanted band, with inertia correction

The last two go through stages that can be stored one by one: `mesh`, `modes` (with the check-up), `body`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from threadpoolctl import threadpool_limits

from fem.casing.geometry.dimensions import Sensor
from fem.casing.geometry.housing import Housing
from fem.casing.meshing.mesh import CasingMesh
from fem.casing.meshing.sizes import Sizes
from fem.casing.meshing.source import mesh_geometry
from fem.casing.reduced.body import MODES_OVER_BAND, ReducedBody
from fem.casing.reduced.checkup import CheckUp, check_up
from fem.casing.reduced.damping import DampingRatio
from fem.casing.reduced.grounded import Coupling, Ground, GroundedCasing, ground_casing
from fem.casing.reduced.modes import CasingModes, Mounts, casing_modes, grounded_body, reduced_body
from fem.casing.reduced.reduction import reduce_body, reduced_and_counted
from fem.casing.reduced.rigid import rigid_body
from fem.elements.materials import Material
from fem.numerics.linear_solver import Solver


@dataclass(frozen=True, kw_only=True)
class NoCasing:
    """Bearings to ground."""

    model: Literal["none"] = "none"

    def reduce(self, housing: Housing | Mapping[str, Sequence[float]], material: Material | None = None) -> ReducedBody:
        """A body without coordinates. Instead of a housing, bearing points {name: (x, y, z)} (m) will do."""
        if isinstance(housing, Housing):
            return grounded_body({bore.name: tuple(housing.bore_centre(bore)) for bore in housing.bores})
        return grounded_body(housing)


@dataclass(frozen=True, kw_only=True)
class RigidCasing:
    """A rigid body on one spring per foot."""

    model: Literal["rigid"] = "rigid"
    mount_stiffness: float = 2e8  # N/m of each foot, in x, y and z
    damping_ratio: DampingRatio = 0.01

    def reduce(self, housing: Housing, material: Material) -> ReducedBody:
        """Six coordinates; mass and inertia from the volumes of the housing."""
        return rigid_body(
            housing,
            density=material.density,
            mount_stiffness=self.mount_stiffness,
            damping_ratio=self.damping_ratio,
            sensors=housing.sensors,
        )


@dataclass(frozen=True, kw_only=True)
class _Elastic(ABC):
    """What the rungs with finite elements share."""

    element_size: float = 0.022  # m
    ground: Ground = "fixed"
    coupling: Coupling = "mean"
    interfaces: Mapping[str, Sequence[str]] | None = None  # bearing -> axes that carry loads; all by default
    mounts: Mounts | None = None  # stiffness of the feet, if the ground is "springs"
    damping: DampingRatio = 0.01
    solver: Solver = "auto"

    def mesh(self, housing: Housing) -> CasingMesh:
        """First stage: geometry to tetrahedra."""
        return _mesh(housing, self.element_size)

    def casing(self, mesh: CasingMesh, material: Material) -> GroundedCasing:
        """The meshed casing in its ground, factorised."""
        return ground_casing(
            mesh,
            material,
            interfaces=self.interfaces,
            ground=self.ground,
            coupling=self.coupling,
            solver=self.solver,
        )

    @abstractmethod
    def modes(self, mesh: CasingMesh, material: Material) -> tuple[CasingModes, CheckUp]:
        """Second stage: factorise and reduce; the check-up tells whether the result can be trusted."""

    def body(self, modes: CasingModes, sensors: Sequence[Sensor] = ()) -> ReducedBody:
        """Last stage: mounts, damping and the rows of the sensors asked."""
        return reduced_body(modes, sensors=sensors, damping=self.damping, mounts=self.mounts)

    def reduce(self, housing: Housing, material: Material) -> ReducedBody:
        """All stages."""
        return self.body(self.modes(self.mesh(housing), material)[0], housing.sensors)


@dataclass(frozen=True, kw_only=True)
class StaticCasing(_Elastic):
    """Finite elements condensed statically to the bearing points; its inertia is right only far below resonance."""

    model: Literal["static"] = "static"

    def modes(self, mesh: CasingMesh, material: Material) -> tuple[CasingModes, CheckUp]:
        """Second stage: factorise and condense."""
        with threadpool_limits(1):  # the heavy steps run in two halves side by side
            casing = self.casing(mesh, material)
            reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, count=0, enrich=False)
            return casing_modes(casing, reduction, model=self.model, band_limit=0.0), check_up(casing, reduction)


@dataclass(frozen=True, kw_only=True)
class CraigBamptonCasing(_Elastic):
    """Finite elements reduced to the bearing points and every fixed-interface mode to 1.5 times `band`.

    With `frequency_error` as few of these modes are kept as change no frequency up to the band by more than it.
    """

    model: Literal["craig-bampton"] = "craig-bampton"
    band: float = 5000.0  # Hz
    frequency_error: float | None = None
    inertia_correction: bool = True

    def modes(self, mesh: CasingMesh, material: Material) -> tuple[CasingModes, CheckUp]:
        """Second stage: factorise and reduce.

        Raises
        ------
        EigenError : the modes found are not as many as the law of inertia counts
        """
        limit = MODES_OVER_BAND * self.band
        with threadpool_limits(1):  # the heavy steps run in two halves side by side
            casing = self.casing(mesh, material)
            reduction, counted = reduced_and_counted(
                casing.interface, casing.K_free, casing.M_free, highest=limit, enrich=self.inertia_correction
            )
            result = casing_modes(casing, reduction, model=self.model, band_limit=limit, counted=counted)
            return result, check_up(casing, reduction)

    def body(self, modes: CasingModes, sensors: Sequence[Sensor] = ()) -> ReducedBody:
        """Last stage: mounts, damping, the modes that are kept and the rows of the sensors asked."""
        return reduced_body(
            modes,
            sensors=sensors,
            damping=self.damping,
            mounts=self.mounts,
            limit=MODES_OVER_BAND * self.band,
            frequency_error=self.frequency_error,
        )


CasingRung = NoCasing | RigidCasing | StaticCasing | CraigBamptonCasing


def _mesh(housing: Housing, element_size: float) -> CasingMesh:
    return mesh_geometry(housing, Sizes(element=element_size))
