"""EXCITATIONS: forces at a place on a shaft by name, each a frozen class of options that makes its elements."""

from __future__ import annotations

from fem.named_classes import named_class
from mbd.parts.checks import MachineError
from mbd.parts.load import OutsideForce

EXCITATIONS = {
    "torque-ripple": ("mbd.excitations.ripple", "TorqueRipple"),
}


def excitation_class(name: str) -> type[OutsideForce]:
    """The class of that name. MachineError if there is none."""
    found: type[OutsideForce] = named_class(EXCITATIONS, name, "excitation", MachineError)
    return found
