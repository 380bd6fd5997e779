"""Load on the drums: a constant torque, or a container on ropes.

`Rope`: the container (mass m) hangs on n falls that lead to the drums; a drum angle phi lifts it by
phi R/reeving. A drum carries n/drums falls of the stiffness k = (n/drums) EA/L with the length
L = L_0 - phi R/reeving of the rigidly rolling train, and the force max(0, k s + c s') while the stretch
s = phi R/reeving - x > 0; else the rope is slack. c = 2 zeta sqrt(k m/drums).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from mbd.checks import MachineError, finite, not_negative, positive

NO_DRUM = "load: no drum; give at least one y position on the output shaft."


@dataclass(frozen=True, kw_only=True)
class StaticTorque:
    """A constant torque (N m, lowering positive) on each drum, at the positions ``drums`` (m) of ``shaft``."""

    shaft: str
    drums: tuple[float, ...]
    torque: float
    model: Literal["static-torque"] = "static-torque"

    def __post_init__(self) -> None:
        if not self.drums:
            raise MachineError(NO_DRUM)
        finite("load torque", self.torque)


@dataclass(frozen=True, kw_only=True)
class Rope:
    """A container on ropes; ``axial_stiffness`` is EA of one rope (N), ``falls`` their number over all drums."""

    shaft: str
    drums: tuple[float, ...]
    container_mass: float
    drum_radius: float
    falls: int
    axial_stiffness: float
    length: float
    reeving: float = 2.0
    damping_ratio: float = 0.02
    follow_length: bool = True  # False: keep the stiffness of the initial length
    model: Literal["rope"] = "rope"

    def __post_init__(self) -> None:
        if not self.drums:
            raise MachineError(NO_DRUM)
        for name in ("container_mass", "drum_radius", "falls", "axial_stiffness", "length", "reeving"):
            positive(f"rope {name}", getattr(self, name))
        not_negative("rope damping_ratio", self.damping_ratio)

    @property
    def travel_per_radian(self) -> float:
        """Rise of the container per radian of the drum (m)."""
        return self.drum_radius / self.reeving

    @property
    def stiffness_times_length(self) -> float:
        """EA of all falls of one drum (N): k = this / L."""
        return self.falls * self.axial_stiffness / len(self.drums)


Load = StaticTorque | Rope
