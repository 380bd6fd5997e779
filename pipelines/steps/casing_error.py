"""Step `casing error`: the reduced casing against the full model. Built only when it is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from fem.casing.geometry.dimensions import Sensor
from pipelines.steps.casing_modes import CasingModesSpec

if TYPE_CHECKING:
    from fem.casing.meshing.mesh import CasingMesh
    from fem.casing.reduced.accuracy import ErrorStatement
    from fem.casing.reduced.body import ReducedBody
    from fem.casing.reduced.checkup import CheckUp
    from fem.casing.reduced.damping import DampingRatio
    from fem.casing.reduced.modes import CasingModes


@dataclass(frozen=True, kw_only=True)
class CasingErrorSpec:
    """How the casing was reduced, and what is compared: band (Hz), sensors, damping, mounts (N/m)."""

    modes: CasingModesSpec
    band: float
    sensors: tuple[Sensor, ...]
    damping: DampingRatio
    loss_factors: Mapping[str, float]
    mounts: tuple[tuple[float, float, float], ...] | None


def build(
    spec: CasingErrorSpec, *, mesh: CasingMesh, modes: tuple[CasingModes, CheckUp], body: ReducedBody
) -> ErrorStatement:
    """The error statement; both casings with the stiffness factor of the body.

    Parameters
    ----------
    spec : how the casing was reduced, and what is compared
    mesh, modes, body : results of the steps `casing mesh`, `casing modes` and `casing`
    """
    from fem.casing.reduced.accuracy import state_error

    given = spec.modes
    iron = replace(given.material, elastic_modulus=body.stiffness_factor * given.material.elastic_modulus)
    casing = given.model.casing(mesh, iron)
    return state_error(
        casing,
        body,
        band=spec.band,
        sensors=spec.sensors,
        damping=spec.damping,
        loss_factors=spec.loss_factors,
        springs=modes[0].springs(spec.mounts),
    )
