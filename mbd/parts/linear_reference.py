"""Assembly of the linear reference of a machine, from which its elements take their rows and reference loads."""

from __future__ import annotations

import functools
from collections.abc import Iterable

import numpy as np

from mbd.elements.element import Element
from mbd.elements.linear_part import Part
from mbd.parts.coordinate_layout import Layout
from mbd.parts.mesh_reference import nominal_forces, reference_load
from mbd.parts.modal_basis import modal_basis
from mbd.parts.part_checks import MachineError
from mbd.parts.shafts import torsional_stiffness

SLOWEST = 1.0  # rad/s: smoothing speed of a machine that never turns
SMOOTHING = 0.02  # of the highest speed


class Assembly:
    """Matrices (n, n) of the linear parts and of the linear reference of all elements that have been added.

    The rows of an element that is made from the modes must be combinations of these modes.
    """

    def __init__(self, lay: Layout, parts: tuple[Part, ...], band: float) -> None:
        self.layout, self.machine, self.rolling = lay, lay.machine, lay.rolling()
        self.parts, self.band = parts, band
        self.mass, self.damping, self.stiffness = (self._added(name) for name in ("mass", "damping", "stiffness"))
        self.constant_force = sum((c.constant_force(lay) for c in lay.components), np.zeros(lay.size))
        self.elements: list[Element] = []

    def _added(self, matrix: str) -> np.ndarray:
        total = np.zeros((self.layout.size, self.layout.size))
        for part in self.parts:
            total[np.ix_(part.index, part.index)] += getattr(part, matrix)
        return total

    @functools.cached_property
    def gyroscopic(self) -> np.ndarray:
        """G (n, n) of all parts per motor speed."""
        return self._added("gyroscopic")

    def add(self, elements: Iterable[Element]) -> None:
        """Add elements in the given order."""
        for element in elements:
            self.elements.append(element)
            springs = element.rows, element.reference("stiffness"), element.reference("damping")
            for row, k0, c0 in zip(*springs, strict=True):
                if k0 or c0:
                    self.stiffness += k0 * np.outer(row, row)
                    self.damping += c0 * np.outer(row, row)

    @property
    def rows(self) -> np.ndarray:
        """Force rows (row, n) of the elements so far."""
        return np.array([row for element in self.elements for row in element.rows]).reshape(-1, self.layout.size)

    @functools.cached_property
    def mesh_loads(self) -> dict[str, float]:
        """Load (N) by mesh name at which the mesh is linearised for the reference."""
        nominal = nominal_forces(self.machine, inertias=self._inertias)
        return {mesh.name: reference_load(mesh, nominal[mesh.name]) for mesh in self.machine.meshes}

    @property
    def smoothing(self) -> float:
        """Motor speed (rad/s) within which losses change their sign smoothly."""
        return SMOOTHING * self.machine.highest_speed or SLOWEST

    @property
    def _inertias(self) -> dict[str, float]:
        """Moment of inertia (kg m2) by shaft, including all parts that turn with it."""
        turning = self.mass @ self.rolling
        found = {}
        for shaft in self.machine.shafts:
            own = self.layout.index(shaft.name)
            found[shaft.name] = float(self.rolling[own] @ turning[own]) / self.layout.ratios[shaft.name] ** 2
        for component in self.machine.components:
            for name in component.coordinates:
                i, shaft_name = self.layout.names.index(name), component.places[0].shaft
                found[shaft_name] += float(self.rolling[i] * turning[i]) / self.layout.ratios[shaft_name] ** 2
        return found

    @functools.cached_property
    def contact_loads(self) -> dict[str, float]:
        """Force (N) of each mesh by name at t = 0; 0 without a load."""
        return nominal_forces(self.machine, self.machine.starting_torques(), self._inertias)

    @property
    def resting_displacement(self) -> np.ndarray:
        """q (n,) under the constant force, by the linear reference so far; in a free train without rolling."""
        if not self.machine.free:
            return np.linalg.solve(self.stiffness, self.constant_force)
        turning = self.mass @ self.rolling
        rest = self.constant_force - turning * (self.rolling @ self.constant_force) / (self.rolling @ turning)
        held = np.trace(self.stiffness) / len(turning) / float(turning @ turning)
        return np.linalg.solve(self.stiffness + held * np.outer(turning, turning), rest)

    @functools.cached_property
    def modes(self) -> tuple[np.ndarray, np.ndarray]:
        """Phi (n, mode) and omega (mode,) of the linear reference, with the static responses to all forces so far."""
        acting = np.column_stack(
            [self.rows.T, self.constant_force, self.mass @ self.rolling, self.stiffness @ self.rolling]
        )
        try:
            rolling = self.rolling if self.machine.free else None
            return modal_basis(self.mass, self.stiffness, acting, self.band, self.layout.names, rolling)
        except MachineError as error:  # the coordinate named in the error may be due to another, softer shaft
            softest = min(self.machine.shafts, key=torsional_stiffness)
            raise MachineError(
                f"{error} The softest shaft in torsion is {softest.name} with {torsional_stiffness(softest):.3g} "
                "N m/rad."
            ) from error
