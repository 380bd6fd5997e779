"""EXCITATIONS: external forces by name, each a frozen class of options that makes its elements."""

from __future__ import annotations

from fem.named_classes import named_class
from mbd.parts.load import Excitation
from mbd.parts.part_checks import MachineError

EXCITATIONS = {
    "induction-motor": ("mbd.forces.induction_motor", "InductionMotor"),
    "controlled-motor": ("mbd.forces.speed_controller", "SpeedController"),
    "torque-ripple": ("mbd.excitations.ripple", "TorqueRipple"),
    "unbalance": ("mbd.excitations.unbalance", "Unbalance"),
    "bent-shaft": ("mbd.excitations.bent_shaft", "BentShaft"),
    "shaft-force": ("mbd.excitations.outside_force", "ShaftForce"),
    "casing-force": ("mbd.excitations.outside_force", "CasingForce"),
    "base-acceleration": ("mbd.excitations.base_acceleration", "BaseAcceleration"),
}


def excitation_class(name: str) -> type[Excitation]:
    """The class of that name. MachineError if there is none."""
    return named_class(EXCITATIONS, name, "excitation", MachineError)
