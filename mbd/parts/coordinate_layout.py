"""Coordinates of the assembled machine, and rows that give the motion of its parts.

The order is: shafts in machine order, the casing, then coordinates of other components (sway and lift of a container).
q is relative to the frame that rolls with the train: rotation of a node = s ratio phi_m + its coordinate.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fem.casing.reduced.reduced_body import ReducedBody
from mbd.elements.component import Component
from mbd.elements.coordinates import Coordinates
from mbd.parts.machine import Machine
from mbd.parts.machine_casing import MachineCasing
from mbd.parts.part_checks import MachineError
from mbd.parts.shafts import flexibility, shaft_basis, shaft_nodes

BEARING_PLACE_TOLERANCE = 1e-4  # m


@dataclass(frozen=True, eq=False, kw_only=True)
class Layout(Coordinates):
    """Numbers of the coordinates of each part."""

    machine: Machine
    casing: ReducedBody

    @property
    def components(self) -> tuple[Component, ...]:
        """The components of the machine, and the casing."""
        return (*self.machine.components, MachineCasing(body=self.casing))

    @property
    def gravity(self) -> float:
        """Gravity, m/s2, along -z."""
        return self.machine.gravity

    @cached_property
    def ratios(self) -> dict[str, float]:
        """Lifting angle of every shaft by name per motor angle."""
        return self.machine.ratios()

    @cached_property
    def translation(self) -> np.ndarray:
        """X (coordinate, 3): coordinates for a translation of the whole machine by 1 along x, y, z.

        They are 0 for the casing, whose modes may not contain this motion.
        """
        found = np.zeros((self.size, 3))
        for shaft in self.machine.shafts:
            span = self.spans[shaft.name]
            found[span] = [[label.endswith(f":{axis}") for axis in ("ux", "uy", "uz")] for label in self.names[span]]
        for component in self.machine.components:
            for name, motion in zip(component.coordinates, component.translation(), strict=True):
                found[self.names.index(name)] = motion
        return found

    @property
    def ground_inertia(self) -> np.ndarray:
        """M X (coordinate, 3) of all components."""
        return sum((component.ground_inertia(self) for component in self.components), np.zeros((self.size, 3)))

    def sense(self, shaft: str) -> int:
        """+1 if a shaft lifts about +y, else -1."""
        return self.machine.shaft(shaft).sense

    def flexibility(self, shaft: str, y: float, supports: tuple[float, float]) -> float:
        """Deflection over force (m/N) at ``y`` of a shaft alone, simply supported at two stations."""
        return flexibility(self.machine.shaft(shaft), self.shaft_nodes[shaft], y, supports)

    def read_at(self, shaft: str) -> float:
        """Position y at which the rotation of a shaft is recorded: its first gear, else its first end."""
        gears = [mesh.y for mesh in self.machine.meshes if shaft in (mesh.driving, mesh.driven)]
        return gears[0] if gears else self.machine.shaft(shaft).y_start

    def reads_casing(self, name: str) -> bool:
        """Whether the casing has a row of that name."""
        return name in self.casing.row_names

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

    def check_key_point(self, name: str, shaft: str, y: float) -> None:
        """Raise MachineError if the key point ``name`` of the casing is not at ``y`` of the shaft's axis.

        A missing key point is reported by `casing_row`.
        """
        if not len(self.casing.coordinate_names) or name not in self.casing.point_names:
            return
        axis = self.machine.shaft(shaft)
        place = axis.x, y, axis.z
        off = float(np.linalg.norm(self.casing.point_positions[self.casing.point_names.index(name)] - place))
        if off > BEARING_PLACE_TOLERANCE:
            raise MachineError(
                f"bearing {name}: the casing's key point is {off * 1e3:.3f} mm from the shaft's bearing at {place} m. "
                "Build the casing for this shaft layout."
            )

    def rolling(self) -> np.ndarray:
        """R (coordinate,): motion of all coordinates per motor angle if all meshes roll rigidly."""
        pattern = np.zeros(self.size)
        for name, ratio in self.ratios.items():
            span = self.spans[name]
            pattern[span] = [self.sense(name) * ratio if label.endswith(":ry") else 0.0 for label in self.names[span]]
        for component in self.machine.components:
            for name, motion in zip(component.coordinates, component.rolling(self.ratios), strict=True):
                pattern[self.names.index(name)] = motion
        return pattern


def layout(machine: Machine, casing: ReducedBody) -> Layout:
    """Number the coordinates.

    Raises
    ------
    MachineError : a shaft with too many nodes
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
    names += [name for component in machine.components for name in component.coordinates]
    return Layout(machine=machine, casing=casing, shaft_nodes=nodes, bases=bases, spans=spans, names=tuple(names))
