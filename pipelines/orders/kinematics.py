"""What turns how often in a machine: its shafts, the gears on them and its rolling bearings, as a diagnosis needs them.

An order is a number of cycles per turn of a shaft, so that nothing here hangs on the speed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Shaft:
    """`ratio`: its turns per turn of the first shaft, positive."""

    name: str
    ratio: float


@dataclass(frozen=True, kw_only=True)
class Gear:
    """A gear of a pair; pairs are numbered from 1 in `stage`.

    `cycle` is the mesh cycle of the pair where the angle of the shaft is zero, 0 if nobody knows: then the teeth are
    counted from the one that is in mesh there.
    """

    name: str
    shaft: str
    stage: int
    teeth: int
    cycle: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Bearing:
    """A rolling bearing; `orders` are its pass orders per turn of its shaft: BPFO, BPFI, BSF, FTF."""

    name: str
    shaft: str
    orders: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class Kinematics:
    """The machine; `frequency` (Hz) is the nominal speed of the first shaft, None if nobody knows it.

    Where tooth counts are not known there are no gears, and shafts alone are looked at.
    """

    shafts: tuple[Shaft, ...]
    gears: tuple[Gear, ...] = ()
    bearings: tuple[Bearing, ...] = ()
    frequency: float | None = None

    def shaft(self, name: str) -> Shaft:
        """The shaft of a name; KeyError if there is none."""
        return {shaft.name: shaft for shaft in self.shafts}[name]

    def gears_on(self, shaft: str) -> tuple[Gear, ...]:
        """The gears on a shaft."""
        return tuple(gear for gear in self.gears if gear.shaft == shaft)

    def mesh_orders(self) -> dict[int, float]:
        """Tooth meshing of every pair, in orders of the first shaft, by the number of the pair."""
        return {gear.stage: gear.teeth * self.shaft(gear.shaft).ratio for gear in self.gears}
