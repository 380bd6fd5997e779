"""Interface through which a part of the machine gets the coordinates of the system for its matrices and rows.

`mbd.parts.coordinate_layout.Layout` implements it. Parts depend only on this interface and do not import the machine.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False, kw_only=True)
class Coordinates(abc.ABC):
    """Rows are (coordinate,), SI; q is measured in the frame that rolls with the train."""

    names: tuple[str, ...]
    spans: dict[str, slice]  # numbers of the coordinates of a shaft by name, or of "casing"
    shaft_nodes: dict[str, np.ndarray]  # places y (node,) of the nodes of a shaft
    bases: dict[str, np.ndarray]  # T (6 node, own coordinate): displacements of the nodes of a shaft

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.names)

    @property
    @abc.abstractmethod
    def gravity(self) -> float:
        """m/s2, along -z."""

    @property
    @abc.abstractmethod
    def ratios(self) -> Mapping[str, float]:
        """Lifting angle of every shaft by name per motor angle."""

    @property
    @abc.abstractmethod
    def translation(self) -> np.ndarray:
        """X (coordinate, 3): coordinates for a translation of the whole machine by 1 along x, y, z.

        They are 0 for the casing, whose modes may not contain this motion.
        """

    @property
    @abc.abstractmethod
    def ground_inertia(self) -> np.ndarray:
        """M X (coordinate, 3) of all components."""

    @abc.abstractmethod
    def sense(self, shaft: str) -> int:
        """+1 if a shaft lifts about +y, else -1."""

    @abc.abstractmethod
    def flexibility(self, shaft: str, y: float, supports: tuple[float, float]) -> float:
        """Deflection over force (m/N) at ``y`` of a shaft alone, simply supported at two stations."""

    @abc.abstractmethod
    def read_at(self, shaft: str) -> float:
        """Position y at which the rotation of a shaft is recorded: its first gear, else its first end."""

    @abc.abstractmethod
    def reads_casing(self, name: str) -> bool:
        """Whether the casing has a row of that name."""

    @abc.abstractmethod
    def casing_row(self, name: str) -> np.ndarray:
        """Row of a casing point, e.g. ``bearing_1:ux``; zero if the casing has no coordinates."""

    @abc.abstractmethod
    def check_key_point(self, name: str, shaft: str, y: float) -> None:
        """Raise MachineError if the casing's key point of that name is not at ``y`` of the shaft's axis; one that is
        missing is named by `casing_row`."""

    def index(self, owner: str) -> np.ndarray:
        """Numbers of the coordinates of a shaft by name, or of "casing"."""
        return np.arange(self.size)[self.spans[owner]]

    def node_row(self, shaft: str, y: float, coefficients: np.ndarray) -> np.ndarray:
        """Row (coordinate,) of ``coefficients`` (6,) on the displacements of the node at ``y`` of ``shaft``."""
        row = np.zeros(self.size)
        at = 6 * node_at(self.shaft_nodes[shaft], y)
        row[self.spans[shaft]] = coefficients @ self.bases[shaft][at : at + 6]
        return row

    def axis_row(self, shaft: str, y: float, axis: int) -> np.ndarray:
        """Row of one displacement, axis 0..5 = ux uy uz rx ry rz."""
        return self.node_row(shaft, y, np.eye(6)[axis])

    def angle_row(self, shaft: str, y: float) -> np.ndarray:
        """Row of the rotation in the lifting sense."""
        return self.sense(shaft) * self.axis_row(shaft, y, 4)

    def own_row(self, name: str) -> np.ndarray:
        """Row of one coordinate by its name."""
        row = np.zeros(self.size)
        row[self.names.index(name)] = 1.0
        return row


def node_at(nodes: np.ndarray, y: float) -> int:
    """Index of the node at ``y`` (it exists: every station is a node)."""
    return int(np.argmin(abs(nodes - y)))
