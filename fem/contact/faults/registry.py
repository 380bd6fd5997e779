"""FAULTS: the tooth faults by name."""

from __future__ import annotations

from fem.contact.faults.tooth_fault import ToothFault
from fem.gears.gear_checks import GeometryError
from fem.named_classes import named_class

FAULTS = {
    "missing-tooth": ("fem.contact.faults.missing_tooth", "MissingTooth"),
    "chipped-tooth": ("fem.contact.faults.chipped_tooth", "ChippedTooth"),
    "cracked-tooth": ("fem.contact.faults.cracked_tooth", "CrackedTooth"),
    "spalled-tooth": ("fem.contact.faults.spalled_tooth", "SpalledTooth"),
    "pitted-tooth": ("fem.contact.faults.pitted_tooth", "PittedTooth"),
    "worn-tooth": ("fem.contact.faults.worn_tooth", "WornTooth"),
}


def fault_class(kind: str) -> type[ToothFault]:
    """The class of that name. GeometryError if there is none."""
    return named_class(FAULTS, kind, "fault", GeometryError)
