"""Torque sources: drives of given torque instead of speed, and loads by a torque, with or without a rotor.

A source acts on the rotation of a shaft, or on a separate rotor (inertia J) behind a torsional coupling (k, c). Its
torque depends on the time or on its speed; positive drives in the positive sense of the shaft. The kinds are in
`mbd.forces.torque`, `induction_motor` and `speed_controller`.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fem.options import inline, option
from mbd.elements.channel_reading import Reading
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import Element, Rule, Signal
from mbd.elements.linear_part import Matrices, Part, part_on_rows
from mbd.elements.mode_words import ModeWords
from mbd.parts.load import OutsideForce
from mbd.parts.part_checks import Options
from mbd.parts.speed_drive import COUPLING_TORQUE, motor_channels

LEAST_SCALE = 1e-6  # N m


@dataclass(frozen=True, kw_only=True)
class Rotor(Options):
    """The rotor that a torque acts on."""

    inertia: float = option(0.0, unit="kg m2", ge=0, text="moment of inertia of the rotor; 0: none")
    stiffness: float | None = option(
        None,
        unit="N m/rad",
        key="coupling_stiffness_N_m_per_rad",
        gt=0,
        text="torsional stiffness of the coupling between rotor and shaft; without it: the rotor is "
        "fixed to the shaft. Without inertia a coupling has no effect",
    )
    damping: float = option(
        0.0, unit="N m s/rad", key="coupling_damping_N_m_s_per_rad", ge=0, text="torsional damping of that coupling"
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class TorqueSource(OutsideForce):
    """A torque on the rotation at ``y`` (m) of ``shaft`` or on a rotor there."""

    rule: ClassVar[Rule]  # of the element, see `mbd.elements.element.rule`
    rotor: Rotor = inline(Rotor())
    drives: bool = False  # it is a motor, which determines the sense of rotation

    @abstractmethod
    def values(self, ratio: float) -> np.ndarray:
        """Numbers of the rule; ``ratio`` is the speed of the shaft divided by that of the first drive."""

    @property
    @abstractmethod
    def largest(self) -> float:
        """Torque (N m) of greatest magnitude."""

    @abstractmethod
    def at_start(self, speed: float) -> float:
        """Torque (N m) at t = 0 for a speed of the shaft (rad/s)."""

    @property
    def _coupling(self) -> float | None:
        """Stiffness of the coupling between rotor and shaft (N m/rad); None without a coupling."""
        return self.rotor.stiffness if self.rotor.inertia > 0.0 else None

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Angle of a rotor behind a coupling."""
        return () if self._coupling is None else (f"{self.name}:rotor",)

    def rolling(self, ratios: Mapping[str, float]) -> np.ndarray:
        """Angle of the rotor per motor angle: it turns with its shaft."""
        return np.full(len(self.coordinates), ratios[self.shaft])

    def largest_torques(self, gravity: float) -> dict[str, float]:
        """Torque of greatest magnitude."""
        return {self.shaft: self.largest}

    def starting_torques(self, gravity: float, speeds: Mapping[str, float]) -> dict[str, float]:
        """Torque at t = 0."""
        return {self.shaft: self.at_start(speeds[self.shaft])}

    def row(self, lay: Coordinates) -> np.ndarray:
        """Row of the rotation on which the torque acts."""
        return lay.angle_row(self.shaft, self.y) if self._coupling is None else lay.own_row(self.coordinates[0])

    def parts(self, lay: Coordinates) -> Iterator[Part]:
        """Inertia and coupling."""
        if self.rotor.inertia == 0.0:
            return
        words = ModeWords("rotor", "rotors", group=self.name)
        inertia = Matrices(mass=np.array([[self.rotor.inertia]]))
        yield part_on_rows(self.row(lay)[None], name=f"{self.name} rotor", words=words, matrices=inertia)
        if self._coupling is not None:
            yield part_on_rows(
                (lay.angle_row(self.shaft, self.y) - self.row(lay))[None],
                name=f"{self.name} coupling",
                words=ModeWords("coupling", "couplings"),
                matrices=Matrices(stiffness=np.array([[self._coupling]]), damping=np.array([[self.rotor.damping]])),
            )

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """The torque as a nonlinear force."""
        channel = motor_channels(self.name)[2]
        yield Element(
            kind=type(self).__name__,
            name=self.name,
            part=self.name,
            rule=self.rule,
            values=self.values(lay.ratios[self.shaft]),
            rows=self.row(lay)[None],
            row_names=("angle",),
            scale=(max(abs(self.largest), LEAST_SCALE),),
            rolls=True,
            signals=(Signal(channel, "N m", force=(-1.0,)),),
        )

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Angle, speed and torque; torque of the coupling of a rotor."""
        return (*motor_channels(self.name), *(() if self._coupling is None else (self.name + COUPLING_TORQUE,)))

    def readings(self, lay: Coordinates) -> dict[str, Reading]:
        """Channels of its motion."""
        angle, speed, _ = motor_channels(self.name)
        row, ratio = self.row(lay), lay.ratios[self.shaft]
        found = {
            angle: Reading("rad", displacement=row, rigid=(ratio, 0.0, 0.0)),
            speed: Reading("rad/s", velocity=row, rigid=(0.0, ratio, 0.0)),
        }
        if self._coupling is not None:
            twist = row - lay.angle_row(self.shaft, self.y)
            found[self.name + COUPLING_TORQUE] = Reading(
                "N m", displacement=self._coupling * twist, velocity=self.rotor.damping * twist
            )
        return found
