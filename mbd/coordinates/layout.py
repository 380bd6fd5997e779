"""Coordinates of the assembled machine and the rows that read its parts.

Order: shafts in machine order, then the casing, then the coordinates of the load (a container's sway and lift). q
is measured in the frame that rolls with the train: rotation of a node = s ratio phi_m + its coordinate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.casing.reduced.body import ReducedBody
from mbd.parts.checks import MachineError
from mbd.parts.machine import Machine
from mbd.parts.shafts import node_at, shaft_basis, shaft_nodes

BEARING_PLACE_TOLERANCE = 1e-4  # m


@dataclass(frozen=True, eq=False)
class Layout:
    """Where each part sits among the ``size`` coordinates."""

    machine: Machine
    casing: ReducedBody
    nodes: dict[str, np.ndarray]
    bases: dict[str, np.ndarray]
    spans: dict[str, slice]
    names: tuple[str, ...]

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.names)

    def node_row(self, shaft: str, y: float, coefficients: np.ndarray) -> np.ndarray:
        """Row (coordinate,) of ``coefficients`` (6,) on the displacements of the node at ``y`` of ``shaft``."""
        row = np.zeros(self.size)
        at = 6 * node_at(self.nodes[shaft], y)
        row[self.spans[shaft]] = coefficients @ self.bases[shaft][at : at + 6]
        return row

    def axis_row(self, shaft: str, y: float, axis: int) -> np.ndarray:
        """Row of one displacement, axis 0..5 = ux uy uz rx ry rz."""
        return self.node_row(shaft, y, np.eye(6)[axis])

    def angle_row(self, shaft: str, y: float) -> np.ndarray:
        """Row of the rotation in the lifting sense."""
        return self.machine.shaft(shaft).sense * self.axis_row(shaft, y, 4)

    def casing_row(self, name: str) -> np.ndarray:
        """Row of a casing point, e.g. ``bearing_1:ux``; zero if the casing has no coordinates."""
        row = np.zeros(self.size)
        if len(self.casing.coordinate_names):
            try:
                row[self.spans["casing"]] = self.casing.row(name)
            except KeyError:
                raise MachineError(
                    f"casing: has no row {name!r}; a {self.casing.model} casing with "
                    f"{len(self.casing.row_names)} rows was given. Add the key point to the casing."
                ) from None
        return row

    def rolling(self) -> np.ndarray:
        """R (coordinate,): motion of all coordinates per motor angle with every mesh rolling rigidly."""
        pattern = np.zeros(self.size)
        for name, ratio in self.machine.ratios().items():
            span = self.spans[name]
            pattern[span] = [
                self.machine.shaft(name).sense * ratio if label.endswith(":ry") else 0.0 for label in self.names[span]
            ]
        load = self.machine.load
        pattern[self.size - len(load.coordinates) :] = load.rolling(self.machine.ratios()[load.shaft])
        return pattern


def layout(machine: Machine, casing: ReducedBody) -> Layout:
    """Number the coordinates.

    Raises
    ------
    MachineError : a bearing's key point is not where the shaft passes
    """
    nodes, bases, spans = {}, {}, {}
    names: list[str] = []
    for shaft in machine.shafts:
        nodes[shaft.name] = shaft_nodes(shaft, machine.stations(shaft.name))
        bases[shaft.name], labels = shaft_basis(shaft, nodes[shaft.name])
        spans[shaft.name] = slice(len(names), len(names) + len(labels))
        names += labels
    spans["casing"] = slice(len(names), len(names) + len(casing.coordinate_names))
    names += [f"casing:{label}" for label in casing.coordinate_names]
    names += machine.load.coordinates
    _check_bearing_places(machine, casing)
    return Layout(machine, casing, nodes, bases, spans, tuple(names))


def _check_bearing_places(machine: Machine, casing: ReducedBody) -> None:
    if not len(casing.coordinate_names):
        return
    for bearing in machine.bearings:
        if bearing.support == "ground" or bearing.name not in casing.point_names:
            continue  # casing_row names what is missing
        shaft = machine.shaft(bearing.shaft)
        point = casing.point_positions[casing.point_names.index(bearing.name)]
        off = float(np.linalg.norm(point - (shaft.x, bearing.y, shaft.z)))
        if off > BEARING_PLACE_TOLERANCE:
            raise MachineError(
                f"bearing {bearing.name}: the casing's key point is {off * 1e3:.3f} mm from the shaft's bearing at "
                f"({shaft.x}, {bearing.y}, {shaft.z}) m. Build the casing for this shaft layout."
            )
