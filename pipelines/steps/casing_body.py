"""Step `casing`: the reduced body with damping and the recovery rows of the sensors that are asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fem.casing.geometry.dimensions import Sensor
from fem.casing.geometry.housing import Housing
from fem.elements.materials import Material
from pipelines.border.errors import WorkError
from pipelines.engine.step import CountedResult

if TYPE_CHECKING:
    from fem.casing.mesh_error.extrapolation import LowestModes
    from fem.casing.meshing.mesh import CasingMesh
    from fem.casing.reduced.body import ReducedBody
    from fem.casing.reduced.checkup import CheckUp
    from fem.casing.reduced.damping import DampingRatio
    from fem.casing.reduced.modes import CasingModes


@dataclass(frozen=True, kw_only=True)
class GroundSpec:
    """Model `none`: bearing points (m) held by the ground."""

    points: Mapping[str, tuple[float, float, float]]


@dataclass(frozen=True, kw_only=True)
class RigidSpec:
    """Model `rigid`: a housing with its sensors on mount springs (N/m)."""

    housing: Housing
    material: Material
    mount_stiffness: float
    damping_ratio: DampingRatio


@dataclass(frozen=True, kw_only=True)
class RigidMeshSpec:
    """Model `rigid` of a housing whose mass and key points come from its mesh."""

    density: float
    sensors: tuple[Sensor, ...]
    mount_stiffness: float
    damping_ratio: DampingRatio


@dataclass(frozen=True, kw_only=True)
class ElasticSpec:
    """Models `static` and `craig-bampton`: what is added to the modes, and how many of them are kept.

    `loss_factors` of the parts that have their own; `mounts` in N/m, a row for all feet or one per foot, None on fixed
    ground; `limit` (Hz) of the kept modes, None for the model static.
    """

    sensors: tuple[Sensor, ...]
    damping: DampingRatio
    loss_factors: Mapping[str, float]
    mounts: tuple[tuple[float, float, float], ...] | None
    limit: float | None
    frequency_error: float | None


def build_ground(spec: GroundSpec) -> CountedResult:
    """A body without coordinates."""
    from fem.casing.models.no_casing import NoCasing

    return _built(NoCasing().reduce(spec.points))


def build_rigid(spec: RigidSpec) -> CountedResult:
    """Six coordinates."""
    from fem.casing.models.rigid_casing import RigidCasing

    model = RigidCasing(mount_stiffness=spec.mount_stiffness, damping_ratio=spec.damping_ratio)
    return _built(model.reduce(spec.housing, spec.material))


def build_rigid_mesh(spec: RigidMeshSpec, *, mesh: CasingMesh) -> CountedResult:
    """Six coordinates."""
    from fem.casing.reduced.rigid import rigid_from_mesh

    return _built(
        rigid_from_mesh(
            mesh,
            density=spec.density,
            mount_stiffness=spec.mount_stiffness,
            damping_ratio=spec.damping_ratio,
            sensors=spec.sensors,
        )
    )


def build_elastic(
    spec: ElasticSpec, *, modes: tuple[CasingModes, CheckUp], coarser: Sequence[LowestModes]
) -> CountedResult:
    """Bearing coordinates and modes; the stiffness is extrapolated where there are coarser meshes."""
    from fem.casing.mesh_error.extrapolation import ExtrapolationError, measured_limits, stiffness_factor
    from fem.casing.reduced.modes import reduced_body

    try:
        factor = stiffness_factor(measured_limits(modes[0], coarser)) if coarser else 1.0
    except ExtrapolationError as error:
        raise WorkError(str(error)) from error

    return _built(
        reduced_body(
            modes[0],
            sensors=spec.sensors,
            damping=spec.damping,
            loss_factors=spec.loss_factors,
            mounts=spec.mounts,
            limit=spec.limit,
            frequency_error=spec.frequency_error,
            stiffness_factor=factor,
        )
    )


def _built(body: ReducedBody) -> CountedResult:
    recovered = sum(not name.startswith(("bearing_", "ground_")) for name in body.row_names)
    return CountedResult(body, {"casing_coordinates": len(body.coordinate_names), "recovery_rows": recovered})
