"""Interface through which a part of the machine gets the coordinates of the system for its matrices and rows.

`mbd.parts.layout.Layout` implements it. Parts depend only on this interface and do not import the machine.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np


class Coordinates(Protocol):
    """Rows are (coordinate,), SI; q is measured in the frame that rolls with the train."""

    @property
    def size(self) -> int:
        """Number of coordinates."""

    @property
    def gravity(self) -> float:
        """m/s2, along -z."""

    @property
    def ratios(self) -> Mapping[str, float]:
        """Lifting angle of every shaft by name per motor angle."""

    @property
    def translation(self) -> np.ndarray:
        """X (coordinate, 3): coordinates for a translation of the whole machine by 1 along x, y, z.

        They are 0 for the casing, whose modes may not contain this motion.
        """

    @property
    def ground_inertia(self) -> np.ndarray:
        """M X (coordinate, 3) of all components."""

    def sense(self, shaft: str) -> int:
        """+1 if a shaft lifts about +y, else -1."""

    def index(self, owner: str) -> np.ndarray:
        """Numbers of the coordinates of a shaft by name, or of "casing"."""

    def nodes(self, shaft: str) -> np.ndarray:
        """Places y (node,) of the nodes of a shaft."""

    def basis(self, shaft: str) -> np.ndarray:
        """T (6 node, own coordinate): displacements of the nodes of a shaft from its coordinates."""

    def flexibility(self, shaft: str, y: float, supports: tuple[float, float]) -> float:
        """Deflection over force (m/N) at ``y`` of a shaft alone, simply supported at two stations."""

    def read_at(self, shaft: str) -> float:
        """Position y at which the rotation of a shaft is recorded: its first gear, else its first end."""

    def node_row(self, shaft: str, y: float, coefficients: np.ndarray) -> np.ndarray:
        """Row of ``coefficients`` (6,) on the displacements of the node at ``y``."""

    def axis_row(self, shaft: str, y: float, axis: int) -> np.ndarray:
        """Row of one displacement, axis 0..5 = ux uy uz rx ry rz."""

    def angle_row(self, shaft: str, y: float) -> np.ndarray:
        """Row of the rotation in the lifting sense."""

    def own_row(self, name: str) -> np.ndarray:
        """Row of one coordinate by its name."""

    def reads_casing(self, name: str) -> bool:
        """Whether the casing has a row of that name."""

    def casing_row(self, name: str) -> np.ndarray:
        """Row of a casing point, e.g. ``bearing_1:ux``; zero if the casing has no coordinates."""

    def casing_shift(self, name: str) -> np.ndarray:
        """Motion (3,) of a row of the casing for a translation of the whole machine by 1 along x, y, z."""

    def check_key_point(self, name: str, shaft: str, y: float) -> None:
        """Raise MachineError if the casing's key point of that name is not at ``y`` of the shaft's axis."""
