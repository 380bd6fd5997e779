"""Bearings between a shaft and the casing, or the ground: models `rigid`, `linear`, and nonlinear ones such as `hertz`.

With u = (ux, uy, uz, rx, rz) of the shaft less that of its support, the force on the shaft is -K u - C u'; rotation
about the shaft axis is free. K and C are symmetric and positive semidefinite, with any cross terms. The circulatory
part of an oil film (k_xz != k_zx) has no potential and is not allowed. The force of a nonlinear bearing follows from
its ``inside``, e.g. `mbd.forces.rolling_bearing`; K and C are then only the linear reference of that force.

`rigid` holds the three displacements by springs of ``RIGID_STIFFNESS`` and leaves the tilts free. It moves a natural
frequency by the share of strain energy in the bearing, k/``RIGID_STIFFNESS``, i.e. below 1e-3 where everything else is
softer than 1e9 N/m.

The options of a user are in `mbd.forces.bearing_models`, those of rolling elements in `mbd.parts.rolling_elements`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from fem.casing.reduced.reduced_body import BEARING_AXES
from mbd.elements.channel_reading import Reading
from mbd.elements.component import Component, Place
from mbd.elements.coordinates import Coordinates
from mbd.elements.element import Element
from mbd.elements.linear_part import Matrices, Part, part_on_rows
from mbd.elements.mode_words import ModeWords
from mbd.parts.part_checks import MachineError
from mbd.parts.shafts import AXES

DIRECTIONS = ("x", "y", "z")
RIGID_STIFFNESS = 1e12  # N/m


def bearing_force(bearing: str, axis: str) -> str:
    """Force (N) of a bearing on the casing along x, y or z."""
    return f"{bearing}:f{axis}"


def journal_acceleration(bearing: str, axis: str) -> str:
    """Acceleration (m/s2) of the shaft in a bearing."""
    return f"{bearing}:journal_a{axis}"


class Inside(Protocol):
    """Interface of the force of a nonlinear bearing."""

    def element(self, lay: Coordinates, bearing: BearingSpec) -> Element:
        """Element of the force on the rows of BEARING_AXES."""


@dataclass(frozen=True, kw_only=True)
class BearingSpec(Component):
    """A bearing at ``y`` of ``shaft``; with the support "casing" its name is that of the casing's key point.

    ``stiffness`` (5,) is the diagonal in the order of BEARING_AXES: N/m along x, y (the shaft) and z, N m/rad about x
    and z; an axis with stiffness 0 is free.
    ``cross`` adds symmetric cross terms, e.g. ``("ux", "uz", 2e6)``. ``damping_time`` tau (s) gives C = tau K, unless
    ``damping`` (5, 5) is given.
    """

    name: str
    shaft: str
    y: float
    stiffness: tuple[float, float, float, float, float]
    cross: tuple[tuple[str, str, float], ...] = ()
    damping_time: float = 1e-5
    damping: tuple[tuple[float, ...], ...] | None = None
    support: Literal["casing", "ground"] = "casing"
    model: str = "linear"
    inside: Inside | None = None

    def __post_init__(self) -> None:
        where = f"bearing {self.name}"
        semidefinite(f"{where} stiffness", self.stiffness_matrix)
        semidefinite(f"{where} damping", self.damping_matrix)

    @property
    def stiffness_matrix(self) -> np.ndarray:
        """K (5, 5)."""
        matrix = np.diag(np.array(self.stiffness, dtype=float))
        for first, second, value in self.cross:
            i, j = BEARING_AXES.index(first), BEARING_AXES.index(second)
            matrix[i, j] += value
            matrix[j, i] += value
        return matrix

    @property
    def damping_matrix(self) -> np.ndarray:
        """C (5, 5)."""
        return (
            self.damping_time * self.stiffness_matrix if self.damping is None else np.array(self.damping, dtype=float)
        )

    @property
    def words(self) -> ModeWords:
        """Names of modes whose energy is in the bearing; the bearings of a shaft are one group."""
        return ModeWords("bearing", "bearings", group=f"bearings of {self.shaft}")

    @property
    def places(self) -> tuple[Place, ...]:
        """Place of the bearing on its shaft."""
        return (Place(f"bearing {self.name}", self.shaft, self.y),)

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Its force on the casing."""
        return tuple(bearing_force(self.name, axis) for axis in DIRECTIONS)

    def rows(self, lay: Coordinates) -> np.ndarray:
        """Displacements (5, coordinate) of the shaft relative to the support, in the order of BEARING_AXES.

        A casing has no row for a direction without stiffness; the displacement is then relative to the ground.
        """
        if self.support == "casing":
            lay.check_key_point(self.name, self.shaft, self.y)
        return np.array([self._row(lay, axis) for axis in BEARING_AXES])

    def _row(self, lay: Coordinates, axis: str) -> np.ndarray:
        shaft, name = lay.axis_row(self.shaft, self.y, AXES.index(axis)), f"{self.name}:{axis}"
        free = self.stiffness[BEARING_AXES.index(axis)] == 0.0 and not lay.reads_casing(name)
        return shaft if self.support == "ground" or free else shaft - lay.casing_row(name)

    def parts(self, lay: Coordinates) -> Iterator[Part]:
        """Springs and dampers in the directions with stiffness; none for a nonlinear bearing."""
        if self.inside is not None:
            return
        springs, dampers = self.stiffness_matrix, self.damping_matrix
        held = np.flatnonzero(springs.any(axis=0) | dampers.any(axis=0))
        yield part_on_rows(
            self.rows(lay)[held],
            name=self.name,
            words=self.words,
            matrices=Matrices(stiffness=springs[np.ix_(held, held)], damping=dampers[np.ix_(held, held)]),
        )

    def elements(self, lay: Coordinates) -> Iterator[Element]:
        """The force of a nonlinear bearing."""
        if self.inside is not None:
            yield self.inside.element(lay, self)

    def readings(self, lay: Coordinates) -> dict[str, Reading]:
        """Acceleration of the journal, and the force on the casing if it is linear."""
        found = {}
        for axis in DIRECTIONS:
            row = lay.axis_row(self.shaft, self.y, AXES.index(f"u{axis}"))
            found[journal_acceleration(self.name, axis)] = Reading("m/s2", acceleration=row, vibration=True)
        if self.inside is None:
            rows, at = self.rows(lay), [BEARING_AXES.index(f"u{axis}") for axis in DIRECTIONS]
            springs, dampers = self.stiffness_matrix @ rows, self.damping_matrix @ rows
            for axis, i in zip(DIRECTIONS, at, strict=True):
                found[bearing_force(self.name, axis)] = Reading("N", displacement=springs[i], velocity=dampers[i])
        return found

    def resting_force(self, lay: Coordinates, displacement: np.ndarray) -> float:
        """Force (N) at the coordinates (n,) by its linear reference."""
        return float(np.linalg.norm((self.stiffness_matrix @ (self.rows(lay) @ displacement))[:3]))


def rigid_bearing(name: str, shaft: str, y: float, support: Literal["casing", "ground"] = "casing") -> BearingSpec:
    """A rigid bearing: all displacements held, tilts free.

    Parameters
    ----------
    name, shaft : names of the bearing and of the shaft in it
    y : m, place on the shaft
    support : "casing" or "ground"
    """
    k = RIGID_STIFFNESS
    return BearingSpec(
        name=name, shaft=shaft, y=y, stiffness=(k, k, k, 0.0, 0.0), damping_time=0.0,
        support=support, model="rigid",
    )  # fmt: skip


def semidefinite(where: str, matrix: np.ndarray) -> None:
    """Raise MachineError unless ``matrix`` (5, 5) is finite, symmetric and positive semidefinite."""
    if matrix.shape != (5, 5) or not np.isfinite(matrix).all():
        raise MachineError(f"{where}: needs 5 x 5 finite numbers.")
    size = float(abs(matrix).max())
    skew = float(abs(matrix - matrix.T).max())
    if skew > 1e-9 * size:
        raise MachineError(
            f"{where}: is not symmetric (cross terms differ by {skew:.3g}); circulatory terms, of an oil film, follow "
            "no potential and are not modelled. Give the symmetric part."
        )
    scale = np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
    lowest = float(np.linalg.eigvalsh(matrix / np.outer(scale, scale)).min()) if size else 0.0
    if lowest < -1e-9:
        raise MachineError(
            f"{where}: is not positive definite (lowest eigenvalue {lowest:.3g} of the matrix scaled to unit "
            "diagonal). "
            "Reduce the cross stiffness below the geometric mean of the stiffnesses along x and z."
        )
