"""Spall: a pit in a race or an element of a rolling bearing; `mbd.excitations.faulty_bearing` has the path over it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from fem.options import option
from mbd.parts.part_checks import MachineError, Options
from mbd.parts.rolling_elements import RollingElements

SURFACES = ("outer-ring", "inner-ring", "element")
DEEPEST = 0.1  # of the element's diameter
WIDEST = 0.25  # of the circumference


@dataclass(frozen=True, kw_only=True)
class Spall(Options):
    """A spall of a raceway or rolling element of a bearing of model hertz, across its whole contact width."""

    on: Literal["outer-ring", "inner-ring", "element"] = option(text="damaged part; element: the first rolling element")
    width: float = option(unit="mm", gt=0, text="size along the surface in the rolling direction")
    depth: float = option(unit="um", gt=0, text="largest depth below the surface")
    angle: float = option(
        0.0,
        unit="deg",
        ge=-360,
        le=360,
        text="angle of its centre at t = 0: on a ring from +x towards +z; on an element from the contact with the "
        "outer race, in the sense in which the element rolls. On the outer ring take the direction of the load that "
        "gearcase check prints",
    )

    def check(self, elements: RollingElements) -> None:
        """Raise MachineError if the spall does not fit into the bearing."""
        widest = WIDEST * 2 * math.pi * self.surface(elements)
        if self.width > widest:
            raise MachineError(
                f"spall on the {self.place}: width_mm = {self.width * 1e3:.4g} is more than a quarter of the "
                f"circumference. Set at most {widest * 1e3:.4g}."
            )
        deepest = DEEPEST * elements.diameter
        if self.depth > deepest:
            raise MachineError(
                f"spall on the {self.place}: depth_um = {self.depth * 1e6:.4g} is more than a tenth of the element "
                f"diameter. Set at most {deepest * 1e6:.4g}."
            )

    @property
    def place(self) -> str:
        """Damaged part in words: "outer ring", "inner ring", "rolling element"."""
        return "rolling element" if self.on == "element" else self.on.replace("-", " ")

    def surface(self, elements: RollingElements) -> float:
        """Radius (m), in the rolling plane, of the damaged surface."""
        return elements.diameter / 2 if self.on == "element" else abs(race_radius(elements, self.on))


def race_radius(elements: RollingElements, race: str) -> float:
    """Radius (m) of a race in the rolling plane: positive for the outer one, which is hollow, else negative."""
    cosine = math.cos(elements.contact_angle)
    side = 1.0 if race == "outer-ring" else -1.0
    return elements.pitch_diameter / (2 * cosine) * (side + elements.gamma)


def check_overlap(spalls: Iterable[Spall], elements: RollingElements) -> None:
    """Raise MachineError where two spalls of one surface overlap: the path over a spall assumes separate edges."""
    known = list(spalls)
    for i, one in enumerate(known):
        for other in known[:i]:
            turn = math.remainder(one.angle - other.angle, 2 * math.pi)
            if one.on == other.on and abs(turn) * one.surface(elements) < (one.width + other.width) / 2:
                raise MachineError(
                    f"two spalls on the {one.place} overlap: the angle between their centres is "
                    f"{math.degrees(abs(turn)):.4g} deg. Set one wider spall, or correct angle_deg."
                )
