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

    @property
    def strikes(self) -> dict[str, float]:
        """Orders at which damage knocks, by component: that of a rolling element meets both rings, twice per turn."""
        twice = {"BSF": ("2 BSF", 2.0)}
        named = ((twice.get(label, (label, 1.0)), order) for label, order in self.orders.items())
        return {f"{self.name} {label}": times * order for (label, times), order in named}


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

    def shaft_of(self, component: str) -> str:
        """The shaft that a gear or a strike of a bearing sits on; a shaft itself."""
        places = {gear.name: gear.shaft for gear in self.gears}
        places |= {strike: bearing.shaft for bearing in self.bearings for strike in bearing.strikes}
        return places.get(component, component)

    def mesh_orders(self) -> dict[int, float]:
        """Tooth meshing of every pair, in orders of the first shaft, by the number of the pair."""
        return {gear.stage: gear.teeth * self.shaft(gear.shaft).ratio for gear in self.gears}


def needed_seconds(kinematics: Kinematics, turns: int) -> dict[str, float]:
    """Length (s) of a window that holds so many whole turns, wherever the mark of the shaft is, by shaft.

    It is that of one turn more, at the nominal speed.

    Raises
    ------
    ValueError : the nominal speed is not known or 0
    """
    if not kinematics.frequency:
        raise ValueError(f"nominal speed {kinematics.frequency} Hz: no time follows from it. Set a speed above 0.")
    return {shaft.name: (turns + 1) / (shaft.ratio * kinematics.frequency) for shaft in kinematics.shafts}
