"""Names of natural modes after the part that stores their energy."""

from __future__ import annotations

from typing import NamedTuple


class ModeWords(NamedTuple):
    """Modes go to the kind that stores most of their strain energy, then to a part of it if one stores half of that."""

    kind: str
    plural: str  # where no part of the kind stores half
    group: str = ""  # the name under which parts count together, "": each for itself
    always: bool = False  # the modes are called ``plural``, whatever part stores the energy
    has_mass: bool = False  # it owns spring and mass, so that the mean of strain and kinetic energy counts
    moving: str = ""  # what modes are called with more than half of their kinetic energy in it
