"""Spall: a pit in a race or in an element of a rolling bearing, and the path of an element over it.

The element, a circle of radius r in the rolling plane, turns about the edge of the spall as it comes in and goes out:
its centre follows a circular arc about that edge, tangent to its path on the sound race. At the distance s from the
nearer edge, measured along the chord, it has come closer to the race by

    drop = min(depth, r - sqrt(r^2 - s^2) -+ (rho - sqrt(rho^2 - s^2))),

with the radius rho of the race in the rolling plane, minus for the outer race, which is hollow, plus for the inner one.
At most it is the sagitta of the element across the chord of the spall, measured from the race. The same holds for a
spall in the element, whose two edges roll over the race. A deep spall is left with a corner at its middle, where the
element goes over from one edge to the other; a shallow one lets it roll along the bottom.

References
----------
Sawalhi & Randall (2008), Mech. Syst. Signal Process. 22, 1924-1951, part I (depth of a local fault over its angle);
Sawalhi & Randall (2011), Mech. Syst. Signal Process. 25, 846-870 (entry on an arc, impact where the element meets the
other edge).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from fem.numerics.compiled import inner
from mbd.parts.checks import MachineError, finite, positive
from mbd.parts.rolling_elements import RollingElements

SURFACES = ("outer-ring", "inner-ring", "element")
STEEP = 0.9  # of the element's radius: further from the edge every spall of `DEEPEST` is at its bottom
DEEPEST = 0.1  # of the element's diameter
WIDEST = 0.25  # of the circumference


@dataclass(frozen=True, kw_only=True)
class Spall:
    """A pit as wide across as the contact, ``width`` (m) along the surface in the rolling direction, ``depth`` (m).

    ``angle`` (rad) of its middle at t = 0: on a ring from x towards z, on an element from the place that touches the
    outer ring, in the sense in which it rolls. Of the elements the first one has it, at the cage's start.
    """

    on: Literal["outer-ring", "inner-ring", "element"]
    width: float
    depth: float
    angle: float = 0.0

    def __post_init__(self) -> None:
        if self.on not in SURFACES:
            raise MachineError(f"spall: on {self.on!r} is unknown; known: {', '.join(SURFACES)}.")
        positive("spall width", self.width)
        positive("spall depth", self.depth)
        finite("spall angle", self.angle)

    def check(self, elements: RollingElements) -> None:
        """Raise MachineError for a spall that does not fit into the bearing."""
        widest = WIDEST * 2 * math.pi * self.surface(elements)
        if self.width > widest:
            raise MachineError(
                f"spall on the {self.place}: width {self.width * 1e3:.4g} mm is more than a quarter of the "
                f"circumference; give at most {widest * 1e3:.4g} mm."
            )
        deepest = DEEPEST * elements.diameter
        if self.depth > deepest:
            raise MachineError(
                f"spall on the {self.place}: depth {self.depth * 1e6:.4g} um is more than a tenth of the element's "
                f"diameter; give at most {deepest * 1e6:.4g} um."
            )

    @property
    def place(self) -> str:
        """In words: "outer ring", "inner ring", "rolling element"."""
        return "rolling element" if self.on == "element" else self.on.replace("-", " ")

    def surface(self, elements: RollingElements) -> float:
        """Radius (m), in the rolling plane, of the surface that has the spall."""
        return elements.diameter / 2 if self.on == "element" else abs(race_radius(elements, self.on))

    def drop(self, elements: RollingElements, place: float, race: str = "outer-ring") -> float:
        """Drop (m) of an element whose contact lies ``place`` (m) along the surface from the middle of the spall.

        Parameters
        ----------
        elements : the inside of the bearing
        place : m, positive or negative
        race : that a spall in the element rolls over, "outer-ring" or "inner-ring"; of no effect for a ring
        """
        own = race if self.on == "element" else self.on
        shape = self.width, self.depth, self.surface(elements)
        return float(drop_at(place, *shape, elements.diameter / 2, race_radius(elements, own)))


def race_radius(elements: RollingElements, race: str) -> float:
    """Radius (m) of a race in the rolling plane: positive for the outer one, which is hollow, else negative."""
    cosine = math.cos(elements.contact_angle)
    side = 1.0 if race == "outer-ring" else -1.0
    return elements.pitch_diameter / (2 * cosine) * (side + elements.gamma)


def check_apart(spalls: Iterable[Spall], elements: RollingElements) -> None:
    """Raise MachineError where two spalls of one surface overlap: each has edges of its own."""
    known = list(spalls)
    for i, one in enumerate(known):
        for other in known[:i]:
            turn = math.remainder(one.angle - other.angle, 2 * math.pi)
            if one.on == other.on and abs(turn) * one.surface(elements) < (one.width + other.width) / 2:
                raise MachineError(
                    f"two spalls on the {one.place} overlap: {math.degrees(abs(turn)):.4g} deg lie between their "
                    "middles. Give one wider spall, or increase the angle between them."
                )


@inner()
def drop_at(place, width, depth, surface, element, race):
    """Drop (m) of an element over a spall.

    Parameters
    ----------
    place : m, of the contact along the surface, from the middle of the spall
    width, depth : m, of the spall
    surface : m, radius of the surface that has it
    element, race : m, radii of the element and of the race, the latter negative where it bulges
    """
    inside = 0.5 * width - abs(place)
    if inside <= 0.0:
        return 0.0
    across = surface * math.sin(inside / surface)
    if across >= STEEP * element:
        return depth
    return min(depth, _sagitta(element, across) - _sagitta(race, across))


@inner()
def _sagitta(radius, across):
    """r - sqrt(r^2 - s^2) without cancellation; negative with the radius."""
    return across * across / (radius + math.copysign(math.sqrt(radius * radius - across * across), radius))
