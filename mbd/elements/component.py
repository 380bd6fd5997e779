"""Component: base class of everything that a machine is made of: parts, elements, coordinates, channels and loads.

Every method has a neutral default, so that a component defines only what it has. The machine iterates over its
components (`mbd.parts.machine.Machine.components`) and contains no code for a particular kind.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from mbd.elements.channel_reading import Reading
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import Element
from mbd.elements.linear_part import Part


class Place(NamedTuple):
    """Place of a component on a shaft; the shaft has a node there."""

    what: str  # description in the error if the shaft does not reach there
    shaft: str
    y: float  # m


class Link(NamedTuple):
    """Connection that turns the shaft ``second`` at ``ratio`` times the speed of ``first``."""

    name: str
    first: str
    second: str
    ratio: float


class Component:
    """Base of all components."""

    @property
    def places(self) -> tuple[Place, ...]:
        """Places of the component on shafts."""
        return ()

    @property
    def links(self) -> tuple[Link, ...]:
        """Connections between shafts, e.g. of a gear mesh."""
        return ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of additional coordinates, which come last among those of the machine."""
        return ()

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Channels that are recorded by default, see `readings` and `mbd.elements.element.Signal`."""
        return ()

    def rolling(self, ratios: Mapping[str, float]) -> np.ndarray:
        """Motion (additional coordinate,) per motor angle in rigid rolling; ``ratios`` are lifting angles by shaft."""
        return np.zeros(len(self.coordinates))

    def translation(self) -> np.ndarray:
        """Motion (additional coordinate, 3) when the whole machine moves by 1 along x, y, z."""
        return np.zeros((len(self.coordinates), 3))

    def ground_inertia(self, lay: Coordinates) -> np.ndarray:
        """Inertia force (coordinate, 3) per acceleration of the ground along x, y, z: M X of its parts."""
        found = np.zeros((lay.size, 3))
        for part in self.parts(lay):
            found[part.index] += part.mass @ lay.translation[part.index]
        return found

    def parts(self, lay: Coordinates) -> Iterable[Part]:
        """Linear parts: mass, damping and stiffness."""
        return ()

    def elements(self, lay: Coordinates) -> Iterable[Element]:
        """Nonlinear forces."""
        return ()

    def constant_force(self, lay: Coordinates) -> np.ndarray:
        """Constant force (coordinate,)."""
        return np.zeros(lay.size)

    def holding_force(self, lay: Coordinates) -> np.ndarray:
        """Force (coordinate,) that acts only until t = 0."""
        return np.zeros(lay.size)

    def largest_torques(self, gravity: float) -> dict[str, float]:
        """Torque (N m) of greatest magnitude by shaft, positive in its positive sense; gravity in m/s2."""
        return {}

    def starting_torques(self, gravity: float, speeds: Mapping[str, float]) -> dict[str, float]:
        """Torque (N m) by shaft at t = 0, while the shafts turn at ``speeds`` (rad/s)."""
        return self.largest_torques(gravity)

    def readings(self, lay: Coordinates) -> dict[str, Reading]:
        """Channels by name that are computed from the motion."""
        return {}
