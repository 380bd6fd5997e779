"""External forces over time on a shaft or on the casing.

A force F(t) on the row r of its place adds r^T F to the forces on the coordinates. A point of an elastic casing with
such a force is one of its interfaces (`fem.casing.reduced.grounded`), so that its static response is exact.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.options import option
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import Element, Signal, rule
from mbd.excitations.waveform import SweepWave, TableWave, Waveform, wave_value
from mbd.parts.bearings import DIRECTIONS
from mbd.parts.load import OUTSIDE_FORCE, Excitation, OutsideForce
from mbd.parts.part_checks import MachineError

LEAST_SCALE = 1e-9  # N


@rule(__file__)
def force_rule(values, motion, answer):
    """A value over time on a row; ``values`` are those of the waveform."""
    answer.lost[0] = -wave_value(values, motion.time)


def force_channel(name: str) -> str:
    """The force (N) over time."""
    return f"{name}:{OUTSIDE_FORCE}"


@dataclass(frozen=True, eq=False, kw_only=True)
class ForceTable(TableWave):
    """Values over time, linear between the times and constant outside."""

    levels: np.ndarray = option(unit="N", key="forces_N", text="force at these times")


@dataclass(frozen=True, kw_only=True)
class ForceSweep(SweepWave):
    """A swept sine: frequency linear in time, amplitude rising and falling as sin^2."""

    amplitude: float = option(unit="N", gt=0, text="amplitude of the force")


@dataclass(frozen=True, eq=False, kw_only=True)
class ShaftForce(OutsideForce):
    """A force over time on a shaft."""

    model: Literal["shaft-force"] = "shaft-force"
    axis: Literal["x", "y", "z"] = option(text="direction in which it acts")
    force: ForceTable | ForceSweep = option(text="force over time")

    @property
    def channel_names(self) -> tuple[str, ...]:
        """The force."""
        return (force_channel(self.name),)

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """The force on its node."""
        yield _element(self.name, self.force, lay.axis_row(self.shaft, self.y, DIRECTIONS.index(self.axis)))


@dataclass(frozen=True, eq=False, kw_only=True)
class CasingForce(Excitation):
    """A force over time on the casing, at a sensor."""

    model: Literal["casing-force"] = "casing-force"
    point: str = option(text="name of the sensor where it acts")
    axis: Literal["x", "y", "z"] = option(text="channel of that sensor in whose direction it acts")
    force: ForceTable | ForceSweep = option(text="force over time")

    @property
    def casing_rows(self) -> tuple[str, ...]:
        """The row of its point and axis."""
        return (f"{self.point}:u{self.axis}",)

    @property
    def channel_names(self) -> tuple[str, ...]:
        """The force."""
        return (force_channel(self.name),)

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """The force on its point. MachineError if the casing stands still or has no such point."""
        row = lay.casing_row(self.casing_rows[0])
        if not row.any():
            raise MachineError(
                f"{self.name}: {self.point} does not move in this casing. Set another casing.model, or delete the "
                "force."
            )
        yield _element(self.name, self.force, row)


def _element(name: str, force: Waveform, row: np.ndarray) -> Element:
    return Element(
        kind="outside force",
        name=name,
        part=name,
        rule=force_rule,
        values=force.packed,
        rows=row[None],
        row_names=("displacement",),
        scale=(max(force.largest, LEAST_SCALE),),
        signals=(Signal(force_channel(name), "N", force=(-1.0,)),),
    )
