"""The drive laws of a pair by every rung that peers are compared with."""

from __future__ import annotations

from fem.contact.iso import Iso
from fem.contact.law import MeshLaw
from fem.contact.plane import Plane
from fem.gears.geometry import GearPair


def rung_laws(pair: GearPair) -> dict[str, MeshLaw]:
    """Name of the rung -> law of the drive flank, at default settings."""
    return {"iso": Iso().laws(pair)[0], "plane": Plane().laws(pair)[0]}
