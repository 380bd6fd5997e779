"""Bearings: linear springs and dampers between a shaft and the casing, or the ground where there is no casing.

The force on the shaft is -k (u_shaft - u_casing) - c (v_shaft - v_casing) per direction; rotation about the shaft
axis is free.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from mbd.checks import finite, not_negative, positive

BEARING_AXES = ("ux", "uy", "uz", "rx", "rz")


@dataclass(frozen=True, kw_only=True)
class BearingSpec:
    """A bearing at ``y`` of ``shaft``; its name is that of the casing's key point, e.g. ``bearing_1``.

    Stiffness in N/m (ux, uz radial, uy axial) and N m/rad (rx, rz tilt); an axis with stiffness 0 is free.
    ``damping_time`` tau (s) gives c = tau k on each axis.
    """

    name: str
    shaft: str
    y: float
    stiffness_x: float
    stiffness_z: float
    stiffness_axial: float = 0.0
    stiffness_tilt_x: float = 0.0
    stiffness_tilt_z: float = 0.0
    damping_time: float = 1e-5
    model: Literal["linear"] = "linear"

    def __post_init__(self) -> None:
        where = f"bearing {self.name}"
        finite(f"{where} y", self.y)
        positive(f"{where} stiffness_x", self.stiffness_x)
        positive(f"{where} stiffness_z", self.stiffness_z)
        for name in ("stiffness_axial", "stiffness_tilt_x", "stiffness_tilt_z", "damping_time"):
            not_negative(f"{where} {name}", getattr(self, name))

    @property
    def stiffness(self) -> tuple[float, ...]:
        """In the order of BEARING_AXES."""
        return (
            self.stiffness_x,
            self.stiffness_axial,
            self.stiffness_z,
            self.stiffness_tilt_x,
            self.stiffness_tilt_z,
        )
