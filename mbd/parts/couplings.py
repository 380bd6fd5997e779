"""Couplings between two shafts on one axis: linear springs and dampers between a node of each.

The force on the first shaft is -K u - C u' with u = u_1 - u_2, K = diag(k) and C = tau K. A direction of stiffness 0 is
free, as in a coupling that only takes the rotation; where that is free, it is a bearing between two shafts, each of
which turns by itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from mbd.elements.component import Component, Link, Place
from mbd.elements.linear import LinearElement, Part, part_on_rows
from mbd.elements.mode_words import ModeWords
from mbd.parts.checks import MachineError, finite, not_negative
from mbd.parts.shafts import ShaftSpec

if TYPE_CHECKING:
    from mbd.elements.coordinates import Coordinates

COAXIAL = 1e-5  # m


@dataclass(frozen=True, eq=False, kw_only=True)
class CouplingSprings(LinearElement):
    """Springs k (n,), N/m and N m/rad, between both ends, with the damping time tau (s)."""

    springs: np.ndarray
    damping_time: float

    def stiffness(self) -> np.ndarray:
        """K = diag(k) (n, n)."""
        return np.diag(self.springs)

    def damping(self) -> np.ndarray:
        """C = tau K (n, n)."""
        return np.diag(self.damping_time * self.springs)


@dataclass(frozen=True, kw_only=True)
class ShaftCoupling(Component):
    """A coupling between ``shafts`` at their stations ``y`` (m); N/m, N m/rad, damping c = ``damping_time`` k."""

    name: str
    shafts: tuple[str, str]
    y: tuple[float, float]
    torsional_stiffness: float
    radial_stiffness: float = 0.0
    axial_stiffness: float = 0.0
    tilt_stiffness: float = 0.0
    damping_time: float = 0.0

    def __post_init__(self) -> None:
        where = f"coupling {self.name}"
        for y in self.y:
            finite(f"{where} y", y)
        for name in ("torsional_stiffness", "radial_stiffness", "axial_stiffness", "tilt_stiffness", "damping_time"):
            not_negative(f"{where} {name}", getattr(self, name))
        if not any(self.stiffness):
            raise MachineError(f"{where}: has no stiffness in any direction; give one, or leave it out.")
        if self.shafts[0] == self.shafts[1]:
            raise MachineError(f"{where}: both ends are on {self.shafts[0]}; it must join two shafts.")

    def turned(self, turns: Mapping[str, float]) -> Self:
        """The coupling after the shafts by name have turned by ``turns`` (rad, in their own sense)."""
        return self

    @property
    def stiffness(self) -> tuple[float, ...]:
        """In the order ux uy uz rx ry rz."""
        radial, tilt = self.radial_stiffness, self.tilt_stiffness
        return radial, self.axial_stiffness, radial, tilt, self.torsional_stiffness, tilt

    @property
    def places(self) -> tuple[Place, ...]:
        """Both ends."""
        return tuple(Place(f"coupling {self.name}", *end) for end in zip(self.shafts, self.y, strict=True))

    @property
    def links(self) -> tuple[Link, ...]:
        """Both shafts turn alike, if the rotation is held."""
        return (Link(f"coupling {self.name}", *self.shafts, 1.0),) if self.torsional_stiffness else ()

    def parts(self, lay: Coordinates) -> Iterator[Part]:
        """Springs in the directions that it holds."""
        (one, other), (y_one, y_other) = self.shafts, self.y
        held = [axis for axis, k in enumerate(self.stiffness) if k > 0.0]
        springs = np.array([self.stiffness[axis] for axis in held])
        yield part_on_rows(
            np.array([lay.axis_row(one, y_one, axis) - lay.axis_row(other, y_other, axis) for axis in held]),
            name=self.name,
            words=ModeWords("coupling", "couplings"),
            elements=(CouplingSprings(at=tuple(range(len(held))), springs=springs, damping_time=self.damping_time),),
        )


def check_coaxial(coupling: ShaftCoupling, first: ShaftSpec, second: ShaftSpec) -> None:
    """Raise MachineError unless both shafts have one axis and, where they turn alike, one lifting sense."""
    off = math.hypot(first.x - second.x, first.z - second.z)
    if off > COAXIAL:
        raise MachineError(
            f"coupling {coupling.name}: the axes of {first.name} and {second.name} have a distance of "
            f"{off * 1e3:.3f} mm; a coupling joins shafts on one axis. Correct their positions."
        )
    if coupling.torsional_stiffness and first.sense != second.sense:
        raise MachineError(
            f"coupling {coupling.name}: {first.name} and {second.name} have opposite lifting senses; coupled shafts "
            "turn the same way."
        )
