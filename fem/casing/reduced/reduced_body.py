"""ReducedBody: the interface of every casing model to the multibody model."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from fem.casing.parts.casing_choices import MODES_OVER_BAND as MODES_OVER_BAND
from fem.storage.records import Record, array, names, scalar, text

BEARING_AXES = ("ux", "uy", "uz", "rx", "rz")  # load-carrying axes of a bearing; the rotation ry is free


@dataclass(frozen=True, eq=False, kw_only=True)
class ReducedBody(Record):
    """Mass, stiffness and damping in reduced coordinates q, and rows that give the motion of key points, u = rows @ q.

    Coordinates are relative to the ground; `stiffness` includes the grounding. ``row_names`` are ``"<point>:<axis>"``
    with axis in ux uy uz (m) rx ry rz (rad), e.g. ``"bearing_3:ux"``, ``"sensor_3:uz"``; the transposed row applies a
    bearing's generalised force. Model `none` has 0 coordinates and zero rows. Feet are the points ``"ground_1"``, ...,
    with x, y, z of each along ``foot_axis``.
    """

    model: str = text()  # "none" | "rigid" | "static" | "craig-bampton"
    mass: np.ndarray = array("coordinate", "coordinate", units="SI")
    stiffness: np.ndarray = array("coordinate", "coordinate", units="SI")
    damping: np.ndarray = array("coordinate", "coordinate", units="SI")
    coordinate_names: tuple[str, ...] = names("coordinate")  # "bearing_1:ux", ..., "mode_1", ...
    row_names: tuple[str, ...] = names("row")
    rows: np.ndarray = array("row", "coordinate", units="SI")
    ground_inertia: np.ndarray = array("coordinate", "axis", units="SI")  # T^T M X, X the motion by 1 along x, y, z
    row_shifts: np.ndarray = array("row", "axis", units="1")  # X at every row: its motion when the body is shifted
    point_names: tuple[str, ...] = names("point")
    point_positions: np.ndarray = array("point", "axis", units="m")
    foot_stiffness: np.ndarray = array("foot_axis", "coordinate", units="SI")  # force on the feet, see `foot_forces`
    foot_inertia: np.ndarray = array("foot_axis", "axis", units="kg")
    stiffness_factor: float = dataclasses.field(default=1.0, metadata=scalar(units="1").metadata)  # from extrapolation
    notes: tuple[str, ...] = dataclasses.field(default=(), metadata=names("note").metadata)  # warnings

    @property
    def feet(self) -> tuple[str, ...]:
        """Names of the feet, in the order of ``foot_axis``."""
        return tuple(name for name in self.point_names if name.startswith("ground_"))

    def foot_forces(self, displacement: np.ndarray, gravity: float) -> np.ndarray:
        """Force (foot, 3) of the ground on every foot along x, y, z, N, at rest.

        Parameters
        ----------
        displacement : (coordinate,) in equilibrium with the forces at the bearings and the weight of the body
        gravity : m/s2, along -z
        """
        return (self.foot_stiffness @ displacement + gravity * self.foot_inertia[:, 2]).reshape(-1, 3)

    def own_weight(self, gravity: float) -> np.ndarray:
        """Force (coordinate,) of its weight, gravity in m/s2 along -z."""
        return -gravity * self.ground_inertia[:, 2]

    def row(self, name: str) -> np.ndarray:
        """The row (coordinate,) of ``"<point>:<axis>"``; KeyError with the known names if absent."""
        if name not in self.row_names:
            raise KeyError(f"{name!r} is not a row of this casing; known: {', '.join(self.row_names)}")
        return self.rows[self.row_names.index(name)]
