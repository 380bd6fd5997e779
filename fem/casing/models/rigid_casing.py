"""Casing model `rigid`: six coordinates on mount springs; valid below the first elastic mode of the housing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from fem.casing.models.body_stages import RigidRecovery
from fem.casing.models.casing import HousingCasing, Structure
from fem.casing.models.stage import BODY, MESH, PlannedStage
from fem.options import option

if TYPE_CHECKING:
    from fem.casing.geometry.housing import Housing


@dataclass(frozen=True, kw_only=True)
class RigidCasing(HousingCasing):
    """A rigid body on mounts, one per foot: 6 coordinates and no finite elements."""

    model: Literal["rigid"] = "rigid"
    added_modes: ClassVar[int] = 6
    mount_stiffness: float = option(2e8, unit="N/um", gt=0, le=1e7, text="stiffness of each mount along x, y and z")

    def needs_mesh(self, structure: Structure) -> bool:
        """False for a plain box, whose mass and key points follow from formulas."""
        return self._box(structure) is None

    def _box(self, structure: Structure) -> Housing | None:
        from fem.casing.geometry.housing import Housing

        return structure.housing if isinstance(structure.housing, Housing) and structure.housing.plain else None

    def stages(self, structure: Structure) -> tuple[PlannedStage, ...]:
        """The body; unless the housing is a plain box, first its mesh, which gives mass and key points."""
        box, material = self._box(structure), structure.material
        assert material is not None, "the mass needs a density"
        body = RigidRecovery(
            housing=box,
            sensors=structure.sensors,
            density=material.density,
            mount_stiffness=self.mount_stiffness,
            damping_ratio=self.damping_ratio,
        )
        if box is not None:
            return (PlannedStage(name=BODY, stage=body),)
        return self.meshed(structure), PlannedStage(name=BODY, stage=body, takes={"mesh": MESH})
