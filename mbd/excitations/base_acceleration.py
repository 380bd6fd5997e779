"""Acceleration of the ground: all feet, and all bearings on the ground, have the same motion.

Coordinates are relative to the ground. With the motion X of all coordinates for a translation by 1 along the axis, the
inertia force is -M X a(t): M q'' + C q' + K q = f + B^T lambda - M X a(t). For the casing, M X is T^T M X of its mesh.
Modes of a clamped casing, which contain no translation, are thus excited as in the finite-element model.
Accelerometers measure the absolute acceleration, q'' + X a.

References
----------
Clough & Penzien (1993), Dynamics of Structures, 2nd ed., chapters 2 and 26 (support excitation, effective force).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.options import option
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import Element, Signal
from mbd.excitations.outside_force import force_rule
from mbd.excitations.waveform import SweepWave, TableWave
from mbd.parts.bearings import DIRECTIONS
from mbd.parts.load import GROUND_ACCELERATION, Excitation

LEAST_SCALE = 1e-9  # m/s2


def base_channel(name: str) -> str:
    """The acceleration (m/s2) of the ground."""
    return f"{name}:{GROUND_ACCELERATION}"


@dataclass(frozen=True, eq=False, kw_only=True)
class AccelerationTable(TableWave):
    """Values over time, linear between the times and constant outside."""

    levels: np.ndarray = option(unit="m/s2", key="accelerations_m_s2", text="acceleration at these times")


@dataclass(frozen=True, kw_only=True)
class AccelerationSweep(SweepWave):
    """A swept sine: frequency linear in time, amplitude rising and falling as sin^2."""

    amplitude: float = option(unit="m/s2", key="amplitude_m_s2", gt=0, text="amplitude of the acceleration")


@dataclass(frozen=True, eq=False, kw_only=True)
class BaseAcceleration(Excitation):
    """An acceleration of the ground over time: of all feet, and of everything else that is on the ground."""

    model: Literal["base-acceleration"] = "base-acceleration"
    axis: Literal["x", "y", "z"] = option(text="direction in which it acts")
    acceleration: AccelerationTable | AccelerationSweep = option(text="acceleration over time")

    @property
    def channel_names(self) -> tuple[str, ...]:
        """The acceleration."""
        return (base_channel(self.name),)

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """The inertia forces of all parts."""
        axis = DIRECTIONS.index(self.axis)
        yield Element(
            kind="base acceleration",
            name=self.name,
            part=self.name,
            rule=force_rule,
            values=self.acceleration.packed,
            rows=-lay.ground_inertia[:, axis][None],
            row_names=("inertia",),
            scale=(max(self.acceleration.largest, LEAST_SCALE),),
            rolls=True,
            signals=(Signal(base_channel(self.name), "m/s2", force=(-1.0,)),),
            ground_acceleration=tuple(np.eye(3)[axis]),
        )
