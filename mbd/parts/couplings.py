"""Couplings between two shafts on one axis: linear springs and dampers between a node of each.

The force on the first shaft is -K u - C u' with u = u_1 - u_2, K = diag(k) and C = tau K. Directions of stiffness 0 are
free. If only the rotation has stiffness, it is a coupling that transmits torque. If the rotation is free, it is a
bearing between two shafts with independent speeds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from fem.options import check_options, option
from mbd.elements.component import Component, Link, Place
from mbd.elements.coordinates import Coordinates
from mbd.elements.linear_part import Part, part_on_rows, springs
from mbd.elements.mode_words import ModeWords
from mbd.parts.part_checks import MachineError


@dataclass(frozen=True, kw_only=True)
class ShaftCoupling(Component):
    """A coupling between ``shafts`` at their stations ``y`` (m); N/m, N m/rad, damping c = ``damping_time`` k."""

    name: str
    shafts: tuple[str, str]
    y: tuple[float, float] = option(text="y of the coupling on each of them", unit="mm", key="positions_mm")
    torsional_stiffness: float = option(
        text="torsional stiffness; 0: a bearing between two shafts that rotate independently", unit="N m/rad", ge=0
    )
    radial_stiffness: float = option(0.0, text="stiffness along x and z", unit="N/um", ge=0)
    axial_stiffness: float = option(0.0, text="stiffness along the axis", unit="N/um", ge=0)
    tilt_stiffness: float = option(0.0, text="tilting stiffness about x and z", unit="N m/rad", ge=0)
    damping_time: float = option(0.0, text="damping divided by stiffness", unit="us", ge=0, le=1e5)

    def __post_init__(self) -> None:
        where = f"coupling {self.name}"
        check_options(self, MachineError)
        if not any(self.stiffness):
            raise MachineError("all stiffnesses of the coupling are 0. Set one, or delete the coupling")
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
        """Link of equal speeds, if the rotation has stiffness."""
        return (Link(f"coupling {self.name}", *self.shafts, 1.0),) if self.torsional_stiffness else ()

    def parts(self, lay: Coordinates) -> Iterator[Part]:
        """Springs in the directions with stiffness."""
        (one, other), (y_one, y_other) = self.shafts, self.y
        held = [axis for axis, k in enumerate(self.stiffness) if k > 0.0]
        stiffness = np.array([self.stiffness[axis] for axis in held])
        yield part_on_rows(
            np.array([lay.axis_row(one, y_one, axis) - lay.axis_row(other, y_other, axis) for axis in held]),
            name=self.name,
            words=ModeWords("coupling", "couplings"),
            matrices=springs(stiffness, self.damping_time),
        )


@dataclass(frozen=True, kw_only=True)
class CouplingWithAxes(ShaftCoupling):
    """A coupling or bearing between two shafts on one axis. Directions of stiffness 0 are free.

    `radial_stiffness` and `tilt_stiffness` hold along and about the first stiffness axis, those `across` along and
    about the second. The axes turn with the first shaft; those of a joint are its pins. The range of `tilt` keeps its
    angle below 0.1 rad, where the Cardan error of second order holds.
    """

    radial_stiffness_across: float | None = option(
        None,
        text="radial stiffness along the second of two rotating stiffness axes; without it: as along the first",
        unit="N/um",
        ge=0,
    )
    tilt_stiffness_across: float | None = option(
        None,
        text="tilting stiffness about the second of two rotating stiffness axes; without it: as about the first",
        unit="N m/rad",
        ge=0,
    )
    angle: float = option(
        0.0, text="angle of the first stiffness axis at t = 0, from +x towards +z", unit="deg", key="stiff_axis_deg"
    )
    offset: tuple[float, float] = option(
        (0.0, 0.0),
        text="parallel misalignment: x and z of the axis of the second shaft relative to the first",
        unit="um",
    )
    tilt: tuple[float, float] = option(
        (0.0, 0.0),
        text="angular misalignment of the second shaft relative to the first, about x and z",
        unit="mrad",
        ge=-70,
        le=70,
    )
    joint: bool = option(
        False,
        text="true: a universal joint with its speed error; its pins are the stiffness axes",
        key="universal_joint",
    )

    @property
    def across(self) -> tuple[float, float]:
        """Radial and tilting stiffness of the second axis (N/m, N m/rad)."""
        radial, tilt = self.radial_stiffness_across, self.tilt_stiffness_across
        return self.radial_stiffness if radial is None else radial, self.tilt_stiffness if tilt is None else tilt
