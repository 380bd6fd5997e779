"""What the elements of a machine are found from: the layout, reference loads, and the linear reference as it grows."""

from __future__ import annotations

import functools
from collections.abc import Iterable

import numpy as np

from mbd.coordinates.channels import bearing_row
from mbd.coordinates.layout import Layout
from mbd.coordinates.modal_basis import modal_basis
from mbd.forces.element import Element
from mbd.parts.bearings import BEARING_AXES
from mbd.parts.checks import MachineError
from mbd.parts.machine import Machine
from mbd.parts.mesh_reference import nominal_forces, reference_load
from mbd.parts.shafts import torsional_stiffness

SLOWEST = 1.0  # rad/s: smoothing speed of a machine that never turns
SMOOTHING = 0.02  # of the highest speed


class Assembly:
    """Matrices of the linear parts (n, n), to which every element that is added brings its linear reference.

    An element that is found from the modes must have rows that the modes before it span.
    """

    def __init__(
        self, lay: Layout, mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray, force: np.ndarray, band: float
    ) -> None:
        self.layout, self.mass, self.damping, self.stiffness = lay, mass, damping, stiffness
        self.constant_force, self.rolling, self.band = force, lay.rolling(), band
        self.ratios = lay.machine.ratios()
        self.elements: list[Element] = []

    @property
    def machine(self) -> Machine:
        """The machine that is assembled."""
        return self.layout.machine

    def add(self, elements: Iterable[Element]) -> None:
        """Take elements up, in their order."""
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
        """Load (N) by mesh name at which its linear reference is taken."""
        nominal = nominal_forces(self.machine)
        return {mesh.name: reference_load(mesh, nominal[mesh.name]) for mesh in self.machine.meshes}

    @property
    def smoothing(self) -> float:
        """Motor speed (rad/s) over which losses reverse."""
        return SMOOTHING * self.machine.profile.highest or SLOWEST

    def bearing_loads(self) -> dict[str, float]:
        """Force (N) in every bearing by name under the constant force, by the linear reference so far."""
        q = np.linalg.solve(self.stiffness, self.constant_force)
        found = {}
        for bearing in self.machine.bearings:
            motion = np.array([bearing_row(self.layout, bearing, axis) @ q for axis in BEARING_AXES])
            found[bearing.name] = float(np.linalg.norm((bearing.stiffness_matrix @ motion)[:3]))
        return found

    @functools.cached_property
    def modes(self) -> tuple[np.ndarray, np.ndarray]:
        """Phi (n, mode) and omega (mode,) of the linear reference, with the static responses to all forces so far."""
        acting = np.column_stack(
            [self.rows.T, self.constant_force, self.mass @ self.rolling, self.stiffness @ self.rolling]
        )
        try:
            return modal_basis(self.mass, self.stiffness, acting, self.band, self.layout.names)
        except MachineError as error:  # what moves freely need not be what is too soft
            softest = min(self.machine.shafts, key=torsional_stiffness)
            raise MachineError(
                f"{error} The softest shaft in torsion is {softest.name} with {torsional_stiffness(softest):.3g} "
                "N m/rad."
            ) from error
