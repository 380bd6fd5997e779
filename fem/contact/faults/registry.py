"""FAULTS: the faults of teeth by name.

A fault is named by its module and class and imported when it is asked for, so that what one fault does to a law does
not depend on the code of another.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from fem.contact.faults.tooth_fault import ToothFault
from fem.gears.rack import GeometryError

FAULTS = {
    "missing-tooth": ("fem.contact.faults.missing_tooth", "MissingTooth"),
    "chipped-tooth": ("fem.contact.faults.chipped_tooth", "ChippedTooth"),
    "cracked-tooth": ("fem.contact.faults.cracked_tooth", "CrackedTooth"),
    "worn-tooth": ("fem.contact.faults.worn_tooth", "WornTooth"),
}


def tooth_fault(kind: str, **options: Any) -> ToothFault:
    """The fault of that name.

    Raises
    ------
    GeometryError : no such fault
    """
    if kind not in FAULTS:
        raise GeometryError(f"fault {kind!r} is unknown; known: {', '.join(FAULTS)}")
    module, name = FAULTS[kind]
    made: ToothFault = getattr(import_module(module), name)(**options)
    return made
