"""Casing of a machine: matrices, weight and ground inertia of its reduced body. Sensors are in `mbd.parts.channels`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fem.casing.reduced.reduced_body import ReducedBody
from mbd.elements.component import Component
from mbd.elements.coordinates import Coordinates
from mbd.elements.linear_part import Matrices, Part
from mbd.elements.mode_words import ModeWords

NAME = "casing"


@dataclass(frozen=True, eq=False, kw_only=True)
class MachineCasing(Component):
    """The casing of a machine; a body without coordinates is the ground."""

    body: ReducedBody

    def ground_inertia(self, lay: Coordinates) -> np.ndarray:
        """M X (coordinate, 3) as stored with the body; the coordinates of a clamped body contain no translation X."""
        found = np.zeros((lay.size, 3))
        if len(self.body.coordinate_names):
            found[lay.index(NAME)] = self.body.ground_inertia
        return found

    def constant_force(self, lay: Coordinates) -> np.ndarray:
        """Weight of the body; the part on clamped nodes has no coordinate and is taken by the ground."""
        found = np.zeros(lay.size)
        if len(self.body.coordinate_names):
            found[lay.index(NAME)] = self.body.own_weight(lay.gravity)
        return found

    def parts(self, lay: Coordinates) -> Iterator[Part]:
        """The body, if it moves."""
        body, n = self.body, len(self.body.coordinate_names)
        if n:
            yield Part(
                name=NAME,
                words=ModeWords("casing", "casing", always=True, has_mass=True),
                matrices=Matrices(mass=body.mass, damping=body.damping, stiffness=body.stiffness),
                index=lay.index(NAME),
                shape=np.eye(n),
            )
