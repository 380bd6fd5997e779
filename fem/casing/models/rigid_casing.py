"""Casing model `rigid`: six coordinates on mount springs; valid below the first elastic mode of the housing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from fem.casing.geometry.housing import Housing
from fem.casing.reduced.body import ReducedBody
from fem.casing.reduced.damping import DampingRatio
from fem.casing.reduced.rigid import rigid_body
from fem.elements.materials import Material


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
