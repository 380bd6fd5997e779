"""Probe: displacement of a shaft's axis at a place, as a proximity probe on the ground would measure it."""

from __future__ import annotations

from dataclasses import dataclass

from fem.options import option
from mbd.elements.channel_reading import Reading
from mbd.elements.component import Component, Place
from mbd.elements.coordinates import Coordinates
from mbd.parts.bearings import DIRECTIONS
from mbd.parts.part_checks import Options

DISPLACEMENT = ":displacement_"


@dataclass(frozen=True, kw_only=True)
class Probe(Options, Component):
    """A proximity probe on the ground: displacement of the axis of a shaft along x, y and z."""

    name: str = option(text="up to 40 letters, digits, _ and -", pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,39}$")
    shaft: str
    y: float = option(text="y of the probe", unit="mm", key="position_mm")

    @property
    def places(self) -> tuple[Place, ...]:
        """Place of the probe along the shaft."""
        return (Place(f"probe {self.name}", self.shaft, self.y),)

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Displacement (m) along x, y and z, from the unloaded straight shaft."""
        return tuple(f"{self.name}{DISPLACEMENT}{axis}" for axis in DIRECTIONS)

    def readings(self, lay: Coordinates) -> dict[str, Reading]:
        """Displacements of the node there."""
        rows = (lay.axis_row(self.shaft, self.y, axis) for axis in range(len(DIRECTIONS)))
        return {name: Reading("m", displacement=row) for name, row in zip(self.channel_names, rows, strict=True)}
