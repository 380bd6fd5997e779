"""Couplings between two shafts on one axis: linear springs and dampers between a node of each.

The force on the first shaft is -k (u_1 - u_2) - c (u_1' - u_2') per axis. Torsion must be held; a direction of
stiffness 0 is free, as in a coupling that only takes the rotation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mbd.parts.checks import MachineError, finite, not_negative, positive
from mbd.parts.shafts import ShaftSpec

COAXIAL = 1e-5  # m


@dataclass(frozen=True, kw_only=True)
class ShaftCoupling:
    """A coupling between ``shafts`` at their stations ``y`` (m); N/m, N m/rad, damping c = ``damping_time`` k."""

    name: str
    shafts: tuple[str, str]
    y: tuple[float, float]
    torsional_stiffness: float
    radial_stiffness: float = 0.0
    axial_stiffness: float = 0.0
    tilt_stiffness: float = 0.0
    damping_time: float = 0.0

    def __post_init__(self) -> None:
        where = f"coupling {self.name}"
        for y in self.y:
            finite(f"{where} y", y)
        positive(f"{where} torsional_stiffness", self.torsional_stiffness, "A coupling must hold the rotation.")
        for name in ("radial_stiffness", "axial_stiffness", "tilt_stiffness", "damping_time"):
            not_negative(f"{where} {name}", getattr(self, name))
        if self.shafts[0] == self.shafts[1]:
            raise MachineError(f"{where}: both ends are on {self.shafts[0]}; it must join two shafts.")

    @property
    def stiffness(self) -> tuple[float, ...]:
        """In the order ux uy uz rx ry rz."""
        radial, tilt = self.radial_stiffness, self.tilt_stiffness
        return radial, self.axial_stiffness, radial, tilt, self.torsional_stiffness, tilt


def check_coaxial(joint: ShaftCoupling, first: ShaftSpec, second: ShaftSpec) -> None:
    """Raise MachineError unless both shafts have one axis and one lifting sense."""
    off = math.hypot(first.x - second.x, first.z - second.z)
    if off > COAXIAL:
        raise MachineError(
            f"coupling {joint.name}: axes of {first.name} and {second.name} are {off * 1e3:.3f} mm apart; a coupling "
            "joins shafts on one axis."
        )
    if first.sense != second.sense:
        raise MachineError(
            f"coupling {joint.name}: {first.name} and {second.name} have opposite lifting senses; coupled shafts turn "
            "the same way."
        )
