"""ReducedBody: a casing as the multibody model sees it, whatever model made it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from fem.storage.records import Record, array, names, scalar, text

BEARING_AXES = ("ux", "uy", "uz", "rx", "rz")  # of a bearing; the rotation ry about the shaft is free
MODES_OVER_BAND = 1.5  # fixed-interface modes are kept to this multiple of the wanted band


@dataclass(frozen=True, eq=False, kw_only=True)
class ReducedBody(Record):
    """Mass, stiffness and damping in reduced coordinates q, and rows that give the motion of key points, u = rows @ q.

    Coordinates are relative to the ground (grounding is already in `stiffness`). ``row_names`` are
    ``"<point>:<axis>"`` with axis in ux uy uz (m) rx ry rz (rad), e.g. ``"bearing_3:ux"``, ``"sensor_3:uz"``;
    a bearing's generalised force enters by the transposed row. Model `none` has 0 coordinates and zero rows.
    """

    model: str = text()  # "none" | "rigid" | "static" | "craig-bampton"
    mass: np.ndarray = array("coordinate", "coordinate", units="SI")
    stiffness: np.ndarray = array("coordinate", "coordinate", units="SI")
    damping: np.ndarray = array("coordinate", "coordinate", units="SI")
    coordinate_names: tuple[str, ...] = names("coordinate")  # "bearing_1:ux", ..., "mode_1", ...
    row_names: tuple[str, ...] = names("row")
    rows: np.ndarray = array("row", "coordinate", units="SI")
    ground_inertia: np.ndarray = array("coordinate", "axis", units="SI")  # T^T M X, X the motion by 1 along x, y, z
    row_shifts: np.ndarray = array("row", "axis", units="1")  # X at every row: what it reads of a shifted body
    point_names: tuple[str, ...] = names("point")
    point_positions: np.ndarray = array("point", "axis", units="m")
    stiffness_factor: float = dataclasses.field(default=1.0, metadata=scalar(units="1").metadata)  # by extrapolation

    def row(self, name: str) -> np.ndarray:
        """The row (coordinate,) of ``"<point>:<axis>"``; KeyError with the known names if absent."""
        if name not in self.row_names:
            raise KeyError(f"{name!r} is not a row of this casing; known: {', '.join(self.row_names)}")
        return self.rows[self.row_names.index(name)]
