"""Kinematics of a machine for a diagnosis: speed ratios of its shafts, their gears, pass orders of rolling bearings.

Orders are cycles per revolution of a shaft and do not depend on the speed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass

GUARD_ORDER = 10.0  # of the fastest shaft: lower end of the band of envelopes if no numbers of teeth are known

PARTS = ("BPFO", "BPFI", "2 BSF", "FTF")  # ends of the names of bearing parts


@dataclass(frozen=True, kw_only=True)
class Shaft:
    """A shaft; `ratio` is its speed divided by that of the first shaft, positive."""

    name: str
    ratio: float


@dataclass(frozen=True, kw_only=True)
class Gear:
    """A gear of the pair with number `stage`, from 1.

    `cycle` is the mesh cycle of the pair where the angle of the shaft is zero. If it is not known it is set to 0; the
    teeth are then numbered from the one that is in mesh at that angle.
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
        """Orders of the impacts by damage of each component. Damage of a rolling element meets both rings: 2 BSF."""
        twice = {"BSF": ("2 BSF", 2.0)}
        named = ((twice.get(label, (label, 1.0)), order) for label, order in self.orders.items())
        return {f"{self.name} {label}": times * order for (label, times), order in named}

    @property
    def sidebands(self) -> dict[str, float]:
        """Distance of the sidebands of the order in `strikes` of the rolling elements: the cage."""
        return {f"{self.name} 2 BSF": self.orders["FTF"]} if {"BSF", "FTF"} <= self.orders.keys() else {}


@dataclass(frozen=True, kw_only=True)
class Kinematics:
    """Shafts, gears and bearings of a machine.

    `frequency` (Hz) is the nominal speed of the first shaft, None if it is not known. If the numbers of teeth are not
    known there are no gears, and only shafts and bearings are diagnosed.
    """

    shafts: tuple[Shaft, ...]
    gears: tuple[Gear, ...] = ()
    bearings: tuple[Bearing, ...] = ()
    frequency: float | None = None

    def shaft(self, name: str) -> Shaft:
        """The shaft with this name; KeyError if there is none."""
        return {shaft.name: shaft for shaft in self.shafts}[name]

    def gears_on(self, shaft: str) -> tuple[Gear, ...]:
        """The gears on a shaft."""
        return tuple(gear for gear in self.gears if gear.shaft == shaft)

    def shaft_of(self, component: str) -> str:
        """Name of the shaft that carries a gear or a bearing of `strikes`; for a shaft its own name."""
        places = {gear.name: gear.shaft for gear in self.gears}
        places |= {strike: bearing.shaft for bearing in self.bearings for strike in bearing.strikes}
        return places.get(component, component)

    def without(self, found: Set[str]) -> tuple[str, ...]:
        """The gears, shafts and bearing parts that are not among some components."""
        parts = [part for bearing in self.bearings for part in bearing.strikes]
        names = [*(gear.name for gear in self.gears), *(shaft.name for shaft in self.shafts), *parts]
        return tuple(name for name in names if name not in found)

    @property
    def envelope_order(self) -> float:
        """Lower end of the band of envelopes in orders of the first shaft: half of the lowest mesh order, if known."""
        meshes = self.mesh_orders().values()
        return 0.5 * min(meshes) if meshes else GUARD_ORDER * max(shaft.ratio for shaft in self.shafts)

    def mesh_orders(self) -> dict[int, float]:
        """Mesh order of every pair, relative to the first shaft, by the number of the pair."""
        return {gear.stage: gear.teeth * self.shaft(gear.shaft).ratio for gear in self.gears}

    def tooth_repeats(self) -> dict[int, float]:
        """Order at which the same two teeth of a pair meet again, relative to the first shaft, by the pair's number.

        Only of pairs whose numbers of teeth have a common divisor: with others it is too low to show as single lines.
        """
        teeth = {stage: [gear.teeth for gear in self.gears if gear.stage == stage] for stage in self.mesh_orders()}
        return {n: order / math.lcm(*teeth[n]) for n, order in self.mesh_orders().items() if math.gcd(*teeth[n]) > 1}


def needed_seconds(shafts: Sequence[Shaft], frequency: float, turns: int) -> dict[str, float]:
    """Length (s) by shaft of a window that contains so many complete turns.

    It is one turn longer, since turns are counted from a mark on the shaft and the window may begin at any angle.

    Parameters
    ----------
    shafts : of the machine
    frequency : of the first shaft, above 0 Hz
    turns : number of complete turns
    """
    return {shaft.name: (turns + 1) / (shaft.ratio * frequency) for shaft in shafts}
