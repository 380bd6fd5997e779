"""Stages `casing` of the casing models: the reduced body, with damping and the rows of sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from fem.casing.models.stage import CasingError, Stage
from fem.storage.ledger import count

if TYPE_CHECKING:
    from fem.casing.geometry.dimensions import Sensor
    from fem.casing.geometry.housing import Housing
    from fem.casing.mesh.mesh import CasingMesh
    from fem.casing.parts.casing_choices import DampingRatio
    from fem.casing.reduced.casing_modes import CasingModes
    from fem.casing.reduced.checkup import CheckUp
    from fem.casing.reduced.reduced_body import ReducedBody
    from fem.casing.uncertainty.extrapolation import LowestModes


@dataclass(frozen=True, kw_only=True)
class Recovery(Stage):
    """Adds damping, mounts and sensor rows to the modes of a casing, and selects the modes kept.

    `loss_factors` belong to parts with a separate one. `mounts` are in N/m, a row for all feet or one per foot, None on
    fixed ground. `limit` (Hz) is that of the modes kept, None for static condensation.
    """

    kind: ClassVar[str] = "casing"
    sensors: tuple[Sensor, ...]
    damping: DampingRatio
    loss_factors: Mapping[str, float]
    mounts: tuple[tuple[float, float, float], ...] | None
    limit: float | None
    frequency_error: float | None = None

    def build(
        self, *, modes: tuple[CasingModes, CheckUp, *tuple[LowestModes, ...]], coarser: Sequence[LowestModes] = ()
    ) -> ReducedBody:
        """Bearing coordinates and modes.

        Parameters
        ----------
        modes : of the casing, with their check-up
        coarser : modes for the extrapolation of its stiffness, if any

        Raises
        ------
        CasingError : the stiffness cannot be extrapolated
        """
        from fem.casing.reduced.casing_modes import reduced_body
        from fem.casing.uncertainty.extrapolation import ExtrapolationError, measured_limits, stiffness_factor

        try:
            factor = stiffness_factor(measured_limits(modes[0], coarser)) if coarser else 1.0
        except ExtrapolationError as error:
            raise CasingError(str(error)) from error
        return _counted(reduced_body(modes[0], stiffness_factor=factor, **vars(self)))


@dataclass(frozen=True, kw_only=True)
class RigidRecovery(Stage):
    """A rigid body on one spring (N/m) per foot; `housing` is None if a mesh gives mass and key points."""

    kind: ClassVar[str] = "casing"
    housing: Housing | None
    sensors: tuple[Sensor, ...]
    density: float
    mount_stiffness: float
    damping_ratio: DampingRatio

    def build(self, *, mesh: CasingMesh | None = None) -> ReducedBody:
        """Six coordinates; `mesh` is that of the housing, if it needs one."""
        from fem.casing.reduced.rigid_on_mounts import rigid_body

        options = {key: value for key, value in vars(self).items() if key != "housing"}
        body = mesh if self.housing is None else self.housing
        assert body is not None, "one of both is known"
        return _counted(rigid_body(body, **options))


@dataclass(frozen=True, kw_only=True)
class BearingsOnGround(Stage):
    """Bearings (positions in m, by name) held by the ground."""

    kind: ClassVar[str] = "casing"
    bearings: Mapping[str, Sequence[float]]

    def build(self) -> ReducedBody:
        """A body without coordinates."""
        from fem.casing.reduced.casing_modes import grounded_body

        return _counted(grounded_body(self.bearings))


def _counted(body: ReducedBody) -> ReducedBody:
    count("casing_coordinates", len(body.coordinate_names))
    count("recovery_rows", sum(not name.startswith(("bearing_", "ground_")) for name in body.row_names))
    return body
