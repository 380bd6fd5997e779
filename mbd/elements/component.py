"""Component: whatever a machine is made of. It brings its parts, elements, coordinates, channels and loads itself.

Everything has a neutral answer, so that a component states only what it has. The machine walks its components
(`mbd.parts.machine.Machine.components`) and knows none of them by name.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from mbd.elements.coordinates import Coordinates
from mbd.elements.element import Element
from mbd.elements.linear import Part
from mbd.elements.reading import Reading


class Place(NamedTuple):
    """Where a component sits on a shaft; a node of the shaft is put there."""

    what: str  # of the error if the shaft does not reach there
    shaft: str
    y: float  # m


class Link(NamedTuple):
    """What turns ``second`` at ``ratio`` times the speed of ``first``."""

    name: str
    first: str
    second: str
    ratio: float


class Component:
    """Base of all components."""

    @property
    def places(self) -> tuple[Place, ...]:
        """Where it sits on shafts."""
        return ()

    @property
    def links(self) -> tuple[Link, ...]:
        """Shafts that it makes turn together."""
        return ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of coordinates of its own, which come last among those of the machine."""
        return ()

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Channels that are recorded unless others are asked for, see `readings` and `mbd.elements.element.Signal`."""
        return ()

    def rolling(self, ratios: Mapping[str, float]) -> np.ndarray:
        """Motion (own coordinate,) per motor angle while the train rolls; lifting angles of the shafts by name."""
        return np.zeros(len(self.coordinates))

    def translation(self) -> np.ndarray:
        """Motion (own coordinate, 3) when all of it moves by 1 along x, y, z."""
        return np.zeros((len(self.coordinates), 3))

    def ground_inertia(self, lay: Coordinates) -> np.ndarray:
        """Inertia force (coordinate, 3) per acceleration of the ground along x, y, z: M X of its parts."""
        found = np.zeros((lay.size, 3))
        for part in self.parts(lay):
            found[part.index] += part.mass @ lay.translation[part.index]
        return found

    def parts(self, lay: Coordinates) -> Iterable[Part]:
        """What it adds to mass, damping and stiffness."""
        return ()

    def elements(self, lay: Coordinates) -> Iterable[Element]:
        """Its nonlinear forces."""
        return ()

    def constant_force(self, lay: Coordinates) -> np.ndarray:
        """Force (coordinate,) that always acts."""
        return np.zeros(lay.size)

    def holding_force(self, lay: Coordinates) -> np.ndarray:
        """Force (coordinate,) that acts until t = 0 only."""
        return np.zeros(lay.size)

    def largest_torques(self, gravity: float) -> dict[str, float]:
        """Torque (N m) of greatest magnitude by shaft, positive in its positive sense; gravity in m/s2."""
        return {}

    def starting_torques(self, gravity: float, speeds: Mapping[str, float]) -> dict[str, float]:
        """Torque (N m) by shaft at t = 0, while the shafts turn at ``speeds`` (rad/s)."""
        return self.largest_torques(gravity)

    def readings(self, lay: Coordinates) -> dict[str, Reading]:
        """Channels by name that are read from the motion."""
        return {}
