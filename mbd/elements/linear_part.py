"""Linear part of a machine: its matrices, and their place in the coordinates of the machine.

A linear part states its mass M, damping C, stiffness K and gyroscopic matrix G (d, d) on its own d displacements u,
with the source of their equations. The forces on u are

    -M u'' - C u' - K u - Omega G u'        stored energy u'^T M u'/2 + u^T K u/2, dissipated power u'^T C u'

A `Part` is one entry of the energy balance and of the energy shares of natural modes. It has matrices on the
displacements u = shape q, which are coordinates or linear combinations of them. `mbd.system.system.assemble` adds the
parts of all components without code for a particular kind.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from mbd.elements.mode_words import ModeWords


@dataclass(frozen=True, eq=False, kw_only=True)
class Matrices:
    """Matrices on d displacements, SI; those not given are zero."""

    mass: np.ndarray | None = None  # M (d, d), symmetric, positive semidefinite
    damping: np.ndarray | None = None  # C (d, d), symmetric, positive semidefinite
    stiffness: np.ndarray | None = None  # K (d, d), symmetric, positive semidefinite
    gyroscopic: np.ndarray | None = None  # G (d, d), skew, per rad/s of the part about +y


def springs(stiffness: np.ndarray, damping_time: float) -> Matrices:
    """Springs k (d,), N/m and N m/rad, with dampers tau k: K = diag(k), C = diag(tau k)."""
    return Matrices(stiffness=np.diag(stiffness), damping=np.diag(damping_time * stiffness))


@dataclass(frozen=True, eq=False, kw_only=True)
class Part:
    """Matrices on the displacements u = ``shape`` q[``index``]; k coordinates, d displacements."""

    name: str
    words: ModeWords
    matrices: Matrices
    index: np.ndarray  # (k,) coordinates
    shape: np.ndarray  # (d, k)
    modes_of: str = ""  # the part to which its energy counts among natural modes, "": its own name
    unstrained: int = 0  # coordinates at its beginning that strain nothing: round-off is removed
    spin: float = 0.0  # rotation about +y per motor angle
    driven: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (d,) motion of far ends per motor angle; or (0,)

    @cached_property
    def mass(self) -> np.ndarray:
        """M (k, k)."""
        return self.shape.T @ self.own("mass") @ self.shape

    @cached_property
    def damping(self) -> np.ndarray:
        """C (k, k)."""
        return self._strained("damping")

    @cached_property
    def stiffness(self) -> np.ndarray:
        """K (k, k)."""
        return self._strained("stiffness")

    @cached_property
    def gyroscopic(self) -> np.ndarray:
        """G (k, k) per motor speed."""
        return self.spin * self.shape.T @ self.own("gyroscopic") @ self.shape

    @property
    def is_massive(self) -> bool:
        """Whether it has inertia; a part without is a spring or damper between parts with inertia."""
        return bool(self.mass.any())

    def own(self, matrix: str) -> np.ndarray:
        """ "mass", "damping", "stiffness" or "gyroscopic" (d, d) on its displacements."""
        given: np.ndarray | None = getattr(self.matrices, matrix)
        return np.zeros((len(self.shape), len(self.shape))) if given is None else given

    def rows(self, size: int) -> np.ndarray:
        """Readings (d, coordinate) of its displacements among ``size`` coordinates."""
        rows = np.zeros((len(self.shape), size))
        rows[:, self.index] = self.shape
        return rows

    def stored(self, displacement: np.ndarray, velocity: np.ndarray) -> float:
        """Kinetic and strain energy (J) at its coordinates (k,) and their rates."""
        kinetic = 0.5 * velocity @ self.mass @ velocity
        return float(kinetic + 0.5 * displacement @ self.stiffness @ displacement)

    def dissipated(self, second: np.ndarray) -> float:
        """Dissipated energy (J) from the integral of v v^T (k, k) over the time."""
        return float(np.sum(self.damping * second))

    def _strained(self, name: str) -> np.ndarray:
        matrix = self.shape.T @ (self.own(name) @ self.shape)
        matrix[: self.unstrained], matrix[:, : self.unstrained] = 0.0, 0.0
        return matrix


def part_on_rows(rows: np.ndarray, **fields: object) -> Part:
    """A part whose displacements are the readings ``rows`` (d, coordinate)."""
    index = np.flatnonzero(np.any(rows != 0.0, axis=0))
    return Part(index=index, shape=rows[:, index], **fields)  # type: ignore[arg-type]
